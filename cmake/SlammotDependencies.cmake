# Everything comes from Debian 12; scripts/install-dependencies names the packages.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Ceres 2.1 REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(fmt REQUIRED)
find_package(ZLIB REQUIRED)
find_package(TBB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc imgcodecs video calib3d videoio)

# OpenBLAS by name: Debian's alternatives may point libblas at the slow reference implementation.
find_library(OPENBLAS_LIBRARY NAMES openblas REQUIRED)
add_library(slammot_blas INTERFACE)
add_library(slammot::blas ALIAS slammot_blas)
set_target_properties(slammot_blas PROPERTIES EXPORT_NAME blas)
target_link_libraries(slammot_blas INTERFACE ${OPENBLAS_LIBRARY})
target_compile_definitions(slammot_blas INTERFACE EIGEN_USE_BLAS)
