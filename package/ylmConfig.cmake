# find_package(ylm REQUIRED COMPONENTS codec scene): targets ylm::ylm and ylm::codec, ylm::scene, ylm::vtk, ylm::vulkan,
# ylm::rival, ylm::mpi as far as they are installed, and ylm::static, the core without a shared library. Places are relative to this file: an installed tree may be moved.

get_filename_component(_ylm_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

function(_ylm_library name file)
  if(NOT TARGET ylm::${name} AND EXISTS "${_ylm_prefix}/lib/${file}")
    add_library(ylm::${name} SHARED IMPORTED)
    set_target_properties(ylm::${name} PROPERTIES
      IMPORTED_LOCATION "${_ylm_prefix}/lib/${file}"
      INTERFACE_INCLUDE_DIRECTORIES "${_ylm_prefix}/include")
    if(NOT name STREQUAL ylm)
      set_target_properties(ylm::${name} PROPERTIES INTERFACE_LINK_LIBRARIES ylm::ylm)
    endif()
  endif()
endfunction()

_ylm_library(ylm libylm.so)
foreach(_ylm_part codec scene vtk vulkan rival mpi)
  _ylm_library(${_ylm_part} libylm_${_ylm_part}.so)
  if(TARGET ylm::${_ylm_part})
    set(ylm_${_ylm_part}_FOUND TRUE)
  endif()
endforeach()

if(NOT TARGET ylm::static AND EXISTS "${_ylm_prefix}/lib/libylm.a")
  add_library(ylm::static STATIC IMPORTED)
  set_target_properties(ylm::static PROPERTIES
    IMPORTED_LOCATION "${_ylm_prefix}/lib/libylm.a"
    INTERFACE_INCLUDE_DIRECTORIES "${_ylm_prefix}/include"
    INTERFACE_LINK_LIBRARIES "-fopenmp;m")
endif()

foreach(_ylm_part ${ylm_FIND_COMPONENTS})
  if(ylm_FIND_REQUIRED_${_ylm_part} AND NOT ylm_${_ylm_part}_FOUND)
    set(ylm_FOUND FALSE)
    set(ylm_NOT_FOUND_MESSAGE "libylm_${_ylm_part}.so is not in ${_ylm_prefix}/lib: what it needs was missing when ylm was built")
  endif()
endforeach()
unset(_ylm_part)
