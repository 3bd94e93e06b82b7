# How our targets are built: warnings, determinism, sanitizers, one function per kind of target.

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_CURRENT_LIST_DIR}/cached ${CCACHE})
endif()

# A file that includes Torch takes 1.5 GB to compile: two at a time, whatever -j says.
set_property(GLOBAL PROPERTY JOB_POOLS torch=2)

function(powderkeg_flags target)
  target_include_directories(${target} PUBLIC ${CMAKE_SOURCE_DIR})
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion
    $<$<BOOL:${POWDERKEG_WERROR}>:-Werror>
    $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>  # part of its -Wconversion, not of g++'s
    # g++ 12 warns of overlapping copies inside std::string (GCC bug 105651).
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
    -ffp-contract=off -fno-math-errno)
  if(POWDERKEG_NATIVE)
    target_compile_options(${target} PRIVATE -march=native)
  endif()
  if(POWDERKEG_SANITIZE)
    target_compile_options(${target} PRIVATE
      -fsanitize=${POWDERKEG_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${POWDERKEG_SANITIZE})
  endif()
endfunction()

# powderkeg_library(name SOURCES ... [LINK public...] [PRIVATE private...])
function(powderkeg_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  powderkeg_flags(${name})
  target_link_libraries(${name} PUBLIC ${ARG_LINK} PRIVATE ${ARG_PRIVATE})
endfunction()

# powderkeg_program(name SOURCES ... LINK ...): a binary in build/<preset>/bin
function(powderkeg_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  powderkeg_flags(${name})
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
endfunction()

# powderkeg_test(name SOURCES ... LINK ... [LABELS slow] [THREADS]): a GoogleTest binary run by ctest
# from the repository's root. THREADS: what it tests has several; ThreadSanitizer has nothing to say
# of the others, which are not built for it. The target test_programs builds all.
add_custom_target(test_programs)
function(powderkeg_test name)
  cmake_parse_arguments(ARG "THREADS" "" "SOURCES;LINK;LABELS" ${ARGN})
  if(POWDERKEG_SANITIZE STREQUAL "thread" AND NOT ARG_THREADS)
    return()
  endif()
  add_executable(${name} ${ARG_SOURCES})
  powderkeg_flags(${name})
  # What is tested is as fast as ever; the tests themselves compile in half the time.
  target_compile_options(${name} PRIVATE $<IF:$<CONFIG:Release>,-O1,-O0>)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gmock GTest::gtest_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests/bin)
  add_dependencies(test_programs ${name})
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES TIMEOUT 600 LABELS "${ARG_LABELS}")
endfunction()
