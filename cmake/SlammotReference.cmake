# `ninja api_reference`: HTML of the headers in build/.../api_reference/html, where Doxygen is there. Our
# comments are plain `//`; the filter shows them to Doxygen as its own. A warning is an error.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  set(DOXYGEN_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/api_reference)
  set(DOXYGEN_PROJECT_BRIEF "${PROJECT_DESCRIPTION}")
  set(DOXYGEN_USE_MDFILE_AS_MAINPAGE docs/site/reference.md)
  set(DOXYGEN_FILE_PATTERNS *.h)
  set(DOXYGEN_EXTRACT_ALL YES)
  set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
  set(DOXYGEN_GENERATE_LATEX NO)
  set(DOXYGEN_QUIET YES)
  set(DOXYGEN_WARN_IF_UNDOCUMENTED NO)
  set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
  set(DOXYGEN_HAVE_DOT NO)
  set(DOXYGEN_FILTER_PATTERNS "*.h=sed -E -f ${PROJECT_SOURCE_DIR}/cmake/doxygen_comments.sed")
  doxygen_add_docs(api_reference docs/site/reference.md models estimation filters smoothers datasets frontend eval apps/app.h
                   WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} COMMENT "API reference")

  # `ninja docs`: the site of all pages, with this reference, the Python package's, the notebook and
  # pages that the program writes, in build/.../site/html. Sphinx is found when it is built
  # (scripts/install-dependencies --docs).
  add_custom_target(docs
    COMMAND ${SLAMMOT_PYTHON} -B ${PROJECT_SOURCE_DIR}/docs/site/build.py ${PROJECT_BINARY_DIR}/site
            $<TARGET_FILE:slammot> --reference ${DOXYGEN_OUTPUT_DIRECTORY}/html
    USES_TERMINAL VERBATIM COMMENT "Site")
  add_dependencies(docs slammot slammot_codecs api_reference)
endif()
