# Run with cmake -P: must stop with the message of cairn_check_use.
cmake_minimum_required(VERSION 3.24)
macro(set_property)
endmacro()
include("${PROJECT_SOURCE_DIR}/lib/cairn_module.cmake")
cairn_check_use(localisation geometry)
cairn_check_use(geometry localisation)
