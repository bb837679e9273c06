# Run by cpack on the folder that it packs: Debian's policy wants these compressed; without a time, so that the same tree
# gives the same bytes.
find_program(GZIP gzip REQUIRED)
set(share ${CPACK_TEMPORARY_INSTALL_DIRECTORY}${CPACK_PACKAGING_INSTALL_PREFIX}/share)
execute_process(COMMAND ${GZIP} -9 -n -f ${share}/doc/slammot/changelog ${share}/man/man1/slammot.1 COMMAND_ERROR_IS_FATAL ANY)
