# What `cmake --install` puts where, and the Debian package. All paths are relative to the prefix, and the command finds its
# data from its own place, so that the tree may be moved as a whole.
install(TARGETS veriflex RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
set(data ${CMAKE_INSTALL_DATADIR}/veriflex)
install(DIRECTORY cases reference DESTINATION ${data})
install(PROGRAMS scripts/report.py DESTINATION ${data}/scripts)
install(DIRECTORY scripts/report scripts/veriflex DESTINATION ${data}/scripts PATTERN __pycache__ EXCLUDE)
install(FILES README.md ARCHITECTURE.md CHANGELOG.md LICENSE CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright) # where Debian looks for it
install(FILES verify/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME result-file.md)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} USE_SOURCE_PERMISSIONS PATTERN __pycache__ EXCLUDE)
install(FILES ${PROJECT_BINARY_DIR}/veriflex.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${PROJECT_BINARY_DIR}/veriflex.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
        RENAME veriflex)

include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/veriflex)
install(EXPORT veriflexTargets NAMESPACE veriflex:: DESTINATION ${package})
configure_package_config_file(scripts/veriflexConfig.cmake.in ${PROJECT_BINARY_DIR}/veriflexConfig.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/veriflexConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/veriflexConfig.cmake ${PROJECT_BINARY_DIR}/veriflexConfigVersion.cmake
        DESTINATION ${package})

add_custom_target(uninstall COMMAND xargs -d "\\n" rm -f -- < ${PROJECT_BINARY_DIR}/install_manifest.txt
                  COMMENT "Removing the files of the last installation")

# `cpack -G DEB` in the build folder. Configured with VERIFLEX_NATIVE=OFF it runs on every machine of the architecture.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The veriflex authors <veriflex@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "verification of elastic bodies in lattice Boltzmann flow")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3, python3-numpy, python3-h5py, python3-matplotlib, python3-jinja2")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "cmake, g++, libeigen3-dev, libspectra-dev, libfmt-dev, libgsl-dev, libssl-dev, libtomlplusplus-dev, libhdf5-dev") # find_package(veriflex)
set(CPACK_STRIP_FILES ON)
include(CPack)
