# What is installed: the program, the library with its headers, pkg-config and CMake packages, the man
# page, the scenes. `cmake --build build --target uninstall` takes it away again; `cpack` in the build
# directory makes a .deb.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tendril)
install(TARGETS tendril RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS tendril_lib EXPORT tendril ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY src/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tendril FILES_MATCHING PATTERN "*.h")
install(EXPORT tendril NAMESPACE tendril:: DESTINATION ${package_dir})
configure_package_config_file(cmake/tendrilConfig.cmake.in ${PROJECT_BINARY_DIR}/tendrilConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tendrilConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tendrilConfig.cmake
              ${PROJECT_BINARY_DIR}/tendrilConfigVersion.cmake DESTINATION ${package_dir})

# libraries by their full names, as they were found
set(pc_libs)
foreach(library ${HDF5_C_LIBRARIES} ${LAPACK_LIBRARIES} ${MPI_C_LIBRARIES} m)
  if(library MATCHES "^[a-z]+$")
    list(APPEND pc_libs -l${library})
  elseif(EXISTS ${library})
    list(APPEND pc_libs ${library})
  endif()
endforeach()
list(REMOVE_DUPLICATES pc_libs)
list(JOIN pc_libs " " pc_libs)
list(TRANSFORM MPI_C_INCLUDE_DIRS PREPEND -I OUTPUT_VARIABLE pc_includes)
list(JOIN pc_includes " " pc_includes)
file(RELATIVE_PATH pc_prefix /x/${CMAKE_INSTALL_LIBDIR}/pkgconfig /x) # wherever it is installed to
configure_file(cmake/tendril.pc.in ${PROJECT_BINARY_DIR}/tendril.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/tendril.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(FILES docs/tendril.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES README.md LICENSE CITATION.cff CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
file(GLOB pages docs/*.md)
install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs)
file(GLOB scenes options/*.opts)
install(FILES ${scenes} DESTINATION ${CMAKE_INSTALL_DATADIR}/tendril/options)
install(DIRECTORY options/data DESTINATION ${CMAKE_INSTALL_DATADIR}/tendril/options)

if(NOT TARGET uninstall)
  add_custom_target(uninstall COMMAND ${CMAKE_COMMAND} -P ${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake
                    WORKING_DIRECTORY ${PROJECT_BINARY_DIR})
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tendril)
set(CPACK_PACKAGE_VENDOR tendril)
set(CPACK_PACKAGE_CONTACT "the tendril authors <tendril@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS openmpi-bin)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "slepc-dev, libhdf5-openmpi-dev, paraview")
include(CPack)
