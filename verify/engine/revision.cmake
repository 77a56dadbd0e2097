# Writes revision.hpp, only when something in it has changed. Run at every build.
execute_process(COMMAND git describe --always --dirty --abbrev=12 WORKING_DIRECTORY ${SOURCE}
                OUTPUT_VARIABLE VERIFLEX_REVISION OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT VERIFLEX_REVISION)
  set(VERIFLEX_REVISION "unknown (no git)")
endif()
configure_file(${SOURCE}/verify/engine/revision.hpp.in ${OUTPUT} @ONLY)
