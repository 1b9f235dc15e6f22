# perimpm_add_plugin(FAMILY NAME [SOURCES file...])
#   Builds the plugin NAME (default source NAME.cpp) of FAMILY transfer, constitutive or fracture into <folder>/FAMILY/NAME.so,
#   where perimpm looks: the folder is PERIMPM_PLUGIN_OUTPUT_DIR, by default "plugins" in the build tree. On x86-64 also a
#   variant per instruction set; perimpm opens the best one that the machine runs. PERIMPM_ISA_VARIANTS OFF builds only the
#   portable one. Used alike inside perimpm and by plugins of your own after find_package(perimpm).
option(PERIMPM_ISA_VARIANTS "Build plugins once per instruction set (x86-64)" ON)

function(perimpm_add_plugin family name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "SOURCES")
  if(NOT family MATCHES "^(transfer|constitutive|fracture)$")
    message(FATAL_ERROR "perimpm_add_plugin: family '${family}' is none of transfer, constitutive, fracture")
  endif()
  if(NOT arg_SOURCES)
    set(arg_SOURCES "${name}.cpp")
  endif()
  foreach(source IN LISTS arg_SOURCES)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" OUTPUT_VARIABLE file)
    get_source_file_property(is_generated "${source}" GENERATED)
    if(NOT is_generated AND NOT source MATCHES "\\$<" AND NOT EXISTS "${file}")
      message(FATAL_ERROR "perimpm_add_plugin(${family} ${name}): there is no file ${file}\n"
        "The source of a plugin has the plugin's name; others are named by SOURCES.")
    endif()
  endforeach()
  if(NOT PERIMPM_PLUGIN_OUTPUT_DIR)
    set(PERIMPM_PLUGIN_OUTPUT_DIR "${CMAKE_CURRENT_BINARY_DIR}/plugins")
  endif()
  set(variants portable)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(variants x86-64-v2)
    if(PERIMPM_ISA_VARIANTS)
      list(APPEND variants x86-64-v3 x86-64-v4)
    endif()
  endif()
  foreach(variant IN LISTS variants)
    set(target "${name}")
    set(folder "${family}")
    if(variant MATCHES "v[34]$")
      set(target "${name}.${variant}")
      set(folder "${family}/${variant}")
    endif()
    add_library(${target} MODULE ${arg_SOURCES})
    target_compile_features(${target} PRIVATE cxx_std_20)
    # Contraction is pinned and no value is assumed away, so that results only depend on the instruction
    # set and on what its estimates of reciprocal roots give.
    target_compile_options(${target} PRIVATE -fno-math-errno -fno-trapping-math -ffp-contract=fast -Wno-psabi
      $<$<NOT:$<CONFIG:Debug>>:-O3>)
    if(NOT variant STREQUAL portable)
      target_compile_options(${target} PRIVATE -march=${variant})
    endif()
    if(variant MATCHES "v4$")
      # GCC 12 warns inside its own AVX-512 headers; what it has to say of the source it says of the other variants, too.
      target_compile_options(${target} PRIVATE -Wno-uninitialized -Wno-maybe-uninitialized)
    endif()
    target_link_libraries(${target} PRIVATE perimpm::core)
    set_target_properties(${target} PROPERTIES
      PREFIX "" SUFFIX ".so" OUTPUT_NAME "${name}"
      CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
      LIBRARY_OUTPUT_DIRECTORY "${PERIMPM_PLUGIN_OUTPUT_DIR}/${folder}")
    if(PERIMPM_PLUGIN_INSTALL_DIR)
      string(REGEX REPLACE "[^/]+" ".." up "${folder}")
      set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/../${up}")
      install(TARGETS ${target} LIBRARY DESTINATION "${PERIMPM_PLUGIN_INSTALL_DIR}/${folder}")
    endif()
  endforeach()
endfunction()
