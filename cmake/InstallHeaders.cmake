# In the tree a header is included by its path, "models/camera.h", which every editor and tool finds;
# installed, as "slammot/models/camera.h", so that a user's own models/ is never meant.
set(folders models estimation filters smoothers datasets frontend eval apps)
list(JOIN folders "|" any_folder)
foreach(folder IN LISTS folders)
  file(GLOB_RECURSE headers RELATIVE ${source} ${source}/${folder}/*.h)
  if(folder STREQUAL apps)
    set(headers apps/app.h)  # the others are its commands'
  endif()
  foreach(header IN LISTS headers)
    file(READ ${source}/${header} text)
    string(REGEX REPLACE "#include \"((${any_folder})/[^\"]+)\"" "#include \"slammot/\\1\"" text "${text}")
    file(WRITE $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/${destination}/${header} "${text}")
  endforeach()
endforeach()
