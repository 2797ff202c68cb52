# SPDX-License-Identifier: MIT
# One function that sets warnings, sanitizers and include paths for every target of the project.

function(loopsift_target_defaults target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  target_include_directories(${target} PUBLIC ${CMAKE_SOURCE_DIR})
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wcast-align
                                           -Wunused -Woverloaded-virtual -Wdouble-promotion -Wno-psabi)
  # Eigen's own OpenMP stays off: the project parallelises outside it (and a team of its own would allocate).
  target_compile_definitions(${target} PUBLIC EIGEN_DONT_PARALLELIZE)
  # Errno and trapping maths are never looked at; without this no loop with a square root is vectorised.
  target_compile_options(${target} PRIVATE -fno-math-errno -fno-trapping-math)
  if(LOOPSIFT_STRICT)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(LOOPSIFT_SANITIZER STREQUAL "address")
    target_compile_options(${target} PUBLIC -fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
  elseif(LOOPSIFT_SANITIZER STREQUAL "thread")
    if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
      message(FATAL_ERROR "The thread sanitizer needs clang: g++'s reports false races in OpenMP. Use the 'tsan' preset.")
    endif()
    target_compile_options(${target} PUBLIC -fsanitize=thread)
    target_link_options(${target} PUBLIC -fsanitize=thread)
  elseif(LOOPSIFT_SANITIZER STREQUAL "fuzzer")
    if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
      message(FATAL_ERROR "libFuzzer needs clang: use the 'fuzz' preset.")
    endif()
    target_compile_options(${target} PUBLIC -fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer
                                            -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
  elseif(NOT LOOPSIFT_SANITIZER STREQUAL "")
    message(FATAL_ERROR "LOOPSIFT_SANITIZER is '${LOOPSIFT_SANITIZER}'; it takes 'address', 'thread', 'fuzzer' or nothing")
  endif()
endfunction()

# loopsift_library(NAME part SOURCES a.cpp … LINKS target …): a static library loopsift_<part>; header-only without sources.
function(loopsift_library)
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;LINKS" ${ARGN})
  set(target loopsift_${ARG_NAME})
  if(ARG_SOURCES)
    add_library(${target} STATIC ${ARG_SOURCES})
    loopsift_target_defaults(${target})
    target_link_libraries(${target} PUBLIC ${ARG_LINKS})
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${CMAKE_SOURCE_DIR})
    target_link_libraries(${target} INTERFACE ${ARG_LINKS})
  endif()
endfunction()

# loopsift_test(NAME unit_geometry [SANITIZED] SOURCES … LINKS …): one GoogleTest program, its cases registered with ctest.
# SANITIZED: CI also runs it under the address and undefined-behaviour sanitizers (target and label `sanitized`): the parsers
# of foreign input and the code that writes through pointers. The preset itself builds and runs any test.
add_custom_target(sanitized)
function(loopsift_test)
  cmake_parse_arguments(ARG "SANITIZED" "NAME" "SOURCES;LINKS" ${ARGN})
  add_executable(${ARG_NAME} ${ARG_SOURCES})
  loopsift_target_defaults(${ARG_NAME})
  target_link_libraries(${ARG_NAME} PRIVATE ${ARG_LINKS} GTest::gmock GTest::gtest_main)
  set(labels unit)
  if(ARG_SANITIZED)
    add_dependencies(sanitized ${ARG_NAME})
    set(labels sanitized)
  endif()
  include(GoogleTest)
  gtest_discover_tests(${ARG_NAME} DISCOVERY_TIMEOUT 120 PROPERTIES TIMEOUT 600 LABELS ${labels})
endfunction()

# loopsift_benchmark(NAME bench_frame SOURCES … LINKS …): one Google Benchmark program; built, never run by ctest.
function(loopsift_benchmark)
  if(NOT LOOPSIFT_BUILD_BENCHMARKS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;LINKS" ${ARGN})
  add_executable(${ARG_NAME} ${ARG_SOURCES})
  loopsift_target_defaults(${ARG_NAME})
  target_link_libraries(${ARG_NAME} PRIVATE ${ARG_LINKS} benchmark::benchmark_main)
endfunction()
