# `cpack -G DEB` in the build folder: one package, with program, Python package and libraries.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The slammot authors <slammot@example.org>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_DESCRIPTION "An extended Kalman filter and a sliding-window smoother for monocular SLAM
among moving objects, with the same measurements, models and priors, and a
judge of accuracy, consistency, labels and cost, also of other programs'
estimates. Sequences are simulated, recorded, or tracked in images.")
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/DebianFiles.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS
    "python3, python3-jinja2, python3-matplotlib, python3-numpy, python3-pandas, python3-pil, python3-plotly, python3-scipy, python3-yaml")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libceres-dev, libcli11-dev, libopencv-dev, nlohmann-json3-dev, zlib1g-dev")
include(CPack)
