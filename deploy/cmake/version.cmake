# cmake -D SOURCE=... -D VERSION=... -D OUTPUT=... -P version.cmake: writes what Version() says, unless it
# stands there already. Without git that is the version alone.
set(DESCRIPTION "")
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -C ${SOURCE} describe --tags --always --dirty
                  OUTPUT_VARIABLE DESCRIPTION OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(DESCRIPTION)
  set(DESCRIPTION " (${DESCRIPTION})")
endif()
configure_file(${SOURCE}/common/base/version.cc.in ${OUTPUT} @ONLY)
