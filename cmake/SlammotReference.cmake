# `ninja api_reference`: HTML in build/.../api_reference/html, where Doxygen is there. Our comments are
# plain `//`; the filter shows them to Doxygen as its own.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  set(DOXYGEN_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/api_reference)
  set(DOXYGEN_PROJECT_BRIEF "${PROJECT_DESCRIPTION}")
  set(DOXYGEN_USE_MDFILE_AS_MAINPAGE README.md)
  set(DOXYGEN_FILE_PATTERNS *.h)
  set(DOXYGEN_EXTRACT_ALL YES)
  set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
  set(DOXYGEN_GENERATE_LATEX NO)
  set(DOXYGEN_QUIET YES)
  set(DOXYGEN_WARNINGS NO)
  set(DOXYGEN_WARN_IF_UNDOCUMENTED NO)
  set(DOXYGEN_FILTER_PATTERNS "*.h=sed -E -f ${PROJECT_SOURCE_DIR}/cmake/doxygen_comments.sed")
  doxygen_add_docs(api_reference README.md models estimation filters smoothers datasets frontend eval apps/app.h
                   WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} COMMENT "API reference")
endif()
