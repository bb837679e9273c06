# Installs BUILD_DIR into a fresh prefix, then configures and builds other people's projects against
# it: the consumer, which is run, and EXTENSION, which tests/extending/test_extension.py runs.
set(work ${BUILD_DIR}/consumer)
file(REMOVE_RECURSE ${work})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(build name source)
  run(${CMAKE_COMMAND} -S ${source} -B ${work}/${name} -G ${GENERATOR}
      -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
      -DCMAKE_PREFIX_PATH=${work}/prefix ${ARGN})
  run(${CMAKE_COMMAND} --build ${work}/${name})
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${work}/prefix)
set(without "")
foreach(package OpenCV Ceres yaml-cpp fmt ZLIB TBB nlohmann_json CLI11)
  list(APPEND without -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
build(build ${CMAKE_CURRENT_LIST_DIR} ${without})
build(extension ${EXTENSION})

execute_process(COMMAND ${work}/build/consumer OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
if(NOT said STREQUAL "pixel 358.0 162.5\n")
  message(FATAL_ERROR "the consumer said '${said}'")
endif()
foreach(file bin/slammot ${PYTHON_DIR}/slammot/report/templates/compare.html share/man/man1/slammot.1
        share/bash-completion/completions/slammot share/doc/slammot/copyright share/doc/slammot/changelog
        ${PYTHON_DIR}/slammot/worker.py)
  if(NOT EXISTS ${work}/prefix/${file})
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()
