# cairn_module(NAME <module> [PART <part>]
#              HEADERS <public headers> SOURCES <sources>
#              [USES <module>|<module>/<part> ...]      modules of a lower layer, or parts of this one
#              [PRIVATE <third-party targets> ...]       heavy libraries, seen by adapters/*.cpp only
#              [HEAVY <sources> ...])                    CGAL/PCL units that compile one at a time
#
# Declares the static library cairn_<module>[_<part>] with the alias cairn::<module>[_<part>].
# The layer of every module stands in tests/architecture/layers.csv; a use that does not go
# strictly downwards is refused here, at configure time.

file(STRINGS "${PROJECT_SOURCE_DIR}/tests/architecture/layers.csv" _cairn_layer_rows)
foreach(_row IN LISTS _cairn_layer_rows)
  if(_row MATCHES "^([0-9]+),([a-z_]+),")
    set(CAIRN_LAYER_${CMAKE_MATCH_2} ${CMAKE_MATCH_1})
  endif()
endforeach()
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
             "${PROJECT_SOURCE_DIR}/tests/architecture/layers.csv")

# cairn_check_use(<from module> <to module>): fails unless `to` lies in a lower layer than `from`.
function(cairn_check_use FROM TO)
  if(FROM STREQUAL TO)
    return()
  endif()
  foreach(_m IN ITEMS ${FROM} ${TO})
    if(NOT DEFINED CAIRN_LAYER_${_m})
      message(FATAL_ERROR "module '${_m}' has no layer in tests/architecture/layers.csv")
    endif()
  endforeach()
  if(NOT CAIRN_LAYER_${TO} LESS CAIRN_LAYER_${FROM})
    message(FATAL_ERROR "module '${FROM}' (layer ${CAIRN_LAYER_${FROM}}) may not use '${TO}' "
                        "(layer ${CAIRN_LAYER_${TO}}): a use must go down. Move data down into "
                        "survey or geometry, or let pipeline join the two.")
  endif()
endfunction()

function(cairn_module)
  cmake_parse_arguments(M "" "NAME;PART" "HEADERS;SOURCES;USES;PRIVATE;HEAVY" ${ARGN})
  if(M_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "cairn_module(${M_NAME}): unknown arguments ${M_UNPARSED_ARGUMENTS}")
  endif()
  set(_id ${M_NAME})
  if(M_PART)
    set(_id ${M_NAME}_${M_PART})
  endif()
  set(_target cairn_${_id})
  set(_heavy_objects "")
  if(M_HEAVY)
    add_library(${_target}_heavy OBJECT ${M_HEAVY})
    set_target_properties(${_target}_heavy PROPERTIES JOB_POOL_COMPILE heavy)
    target_include_directories(${_target}_heavy PRIVATE "${PROJECT_SOURCE_DIR}/lib")
    target_link_libraries(${_target}_heavy PRIVATE cairn_options Eigen3::Eigen ${M_PRIVATE})
    set(_heavy_objects $<TARGET_OBJECTS:${_target}_heavy>)
  endif()
  add_library(${_target} STATIC ${M_SOURCES} ${_heavy_objects})
  add_library(cairn::${_id} ALIAS ${_target})
  if(CAIRN_PARSERS_ONLY)
    # The tests and fuzz targets pull in what they need; the rest stays unbuilt.
    set_target_properties(${_target} PROPERTIES EXCLUDE_FROM_ALL ON)
    if(M_HEAVY)
      set_target_properties(${_target}_heavy PROPERTIES EXCLUDE_FROM_ALL ON)
    endif()
  endif()
  target_sources(${_target} PUBLIC FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}/lib"
                 FILES ${M_HEADERS})
  target_link_libraries(${_target} PRIVATE $<BUILD_INTERFACE:cairn_options>)
  target_link_libraries(${_target} PUBLIC Eigen3::Eigen)
  foreach(_use IN LISTS M_USES)
    string(REGEX REPLACE "/.*" "" _module "${_use}")
    string(REPLACE "/" "_" _use_id "${_use}")
    cairn_check_use(${M_NAME} ${_module})
    target_link_libraries(${_target} PUBLIC cairn::${_use_id})
  endforeach()
  foreach(_lib IN LISTS M_PRIVATE)
    target_link_libraries(${_target} PRIVATE $<BUILD_INTERFACE:${_lib}>)
  endforeach()
endfunction()
