# cpack reads it before it makes a package: a package travels, and must run on any processor.
if(CPACK_POWDERKEG_REFUSED)
  message(FATAL_ERROR " powderkeg: ${CPACK_POWDERKEG_REFUSED}, expected those of deploy/packages, which run on any; "
                      "for this machine alone: cpack -D CPACK_POWDERKEG_REFUSED=")
endif()
