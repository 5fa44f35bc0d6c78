# Compiler switches shared by everything in the project.
#
# -ffp-contract=off and no -ffast-math: the same inputs must give the same bytes on every
# machine, so no fused multiply-add may appear in one build and not in another.

set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
set(CMAKE_CXX_FLAGS_DEV "-O2 -g1")
if(CAIRN_SANITIZE)
  # Instrumented code takes twice as long to compile at -O2, and finds nothing more.
  set(CMAKE_CXX_FLAGS_DEV "-O1 -g1")
endif()

add_library(cairn_options INTERFACE)
target_compile_options(cairn_options INTERFACE
  -ffp-contract=off -fno-fast-math
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion
  -Wold-style-cast -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wunused
  -Wnull-dereference -Wformat=2 -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC's null-dereference and array-bounds analyses look into inlined third-party code and cry wolf.
  target_compile_options(cairn_options INTERFACE
    -Wduplicated-cond -Wlogical-op -Wno-null-dereference)
endif()
if(CAIRN_SANITIZE)
  target_compile_options(cairn_options INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(cairn_options INTERFACE -fsanitize=address,undefined)
endif()
if(CAIRN_FUZZ)
  target_compile_options(cairn_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
