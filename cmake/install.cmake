# What is installed: the program, the library with its header, pkg-config and CMake packages, the man
# page, the scenes. `cmake --build build --target uninstall` takes it away again; `cpack` in the build
# directory makes a .deb.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tendril)
install(TARGETS tendril RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS libtendril EXPORT tendril LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        PUBLIC_HEADER DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT tendril NAMESPACE tendril:: DESTINATION ${package_dir})
configure_package_config_file(cmake/tendrilConfig.cmake.in ${PROJECT_BINARY_DIR}/tendrilConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tendrilConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tendrilConfig.cmake
              ${PROJECT_BINARY_DIR}/tendrilConfigVersion.cmake DESTINATION ${package_dir})

# the header wants MPI; all else is the library's own affair. Libraries by their full names, as they were found
set(pc_libs)
foreach(library ${MPI_C_LIBRARIES})
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
file(GLOB_RECURSE pages RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS docs/*.md)
foreach(page ${pages})
  get_filename_component(folder ${page} DIRECTORY)
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder})
endforeach()
file(GLOB scenes options/*.opts)
install(FILES ${scenes} DESTINATION ${CMAKE_INSTALL_DATADIR}/tendril/options)
install(DIRECTORY options/data DESTINATION ${CMAKE_INSTALL_DATADIR}/tendril/options)

# The Python package. In a wheel, with the program and the scenes; in Debian's own place where Debian's
# own prefix is asked for, as the .deb does, with the gallery.
if(SKBUILD)
  install(TARGETS tendril RUNTIME DESTINATION ${SKBUILD_SCRIPTS_DIR} COMPONENT wheel)
  install(FILES ${scenes} DESTINATION ${SKBUILD_PLATLIB_DIR}/tendril/options COMPONENT wheel)
  install(DIRECTORY options/data DESTINATION ${SKBUILD_PLATLIB_DIR}/tendril/options COMPONENT wheel)
  install(TARGETS libtendril LIBRARY DESTINATION ${SKBUILD_PLATLIB_DIR}/tendril COMPONENT wheel NAMELINK_SKIP)
endif()
set(CPACK_PACKAGE_CONTACT "the tendril authors <tendril@example.org>")
configure_file(cmake/debian.cmake.in ${PROJECT_BINARY_DIR}/debian.cmake @ONLY)
install(SCRIPT ${PROJECT_BINARY_DIR}/debian.cmake)

if(NOT TARGET uninstall)
  add_custom_target(uninstall COMMAND ${CMAKE_COMMAND} -P ${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake
                    WORKING_DIRECTORY ${PROJECT_BINARY_DIR})
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tendril)
set(CPACK_PACKAGE_VENDOR tendril)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "slow growth of an elastic fibre that friction holds back")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
    "tendril computes how a root, a vine robot, a cable or a catheter moves
that lengthens slowly against friction: its shape, forces and energies,
and the length at which its straight shape gives way. The program, a C
library with headers, the Python package tendril, and a gallery of scenes.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS
    "openmpi-bin, python3, python3-numpy, python3-scipy, python3-h5py, python3-matplotlib, python3-pandas, python3-xarray, python3-tqdm")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "slepc-dev, libhdf5-openmpi-dev, paraview")
include(CPack)
