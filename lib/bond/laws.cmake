# The bond laws: one line per law, header = type. Made into bond/laws.hpp and, for loops that are compiled once for each
# law, bond/each_law.inc.
set(laws
  harmonic=Harmonic
  fene_lj=FeneLj
  shifted_fene=ShiftedFene
)

set(law_includes "")
set(law_types "")
set(each_law "")
foreach(law IN LISTS laws)
  string(REPLACE "=" ";" law ${law})
  list(GET law 0 header)
  list(GET law 1 type)
  string(APPEND law_includes "#include \"bond/${header}.hpp\"\n")
  list(APPEND law_types ${type})
  string(APPEND each_law "VERIFLEX_LAW(${type})\n")
endforeach()
list(JOIN law_types ", " law_types)
configure_file(${CMAKE_CURRENT_SOURCE_DIR}/bond/laws.hpp.in ${PROJECT_BINARY_DIR}/include/laws/bond/laws.hpp @ONLY)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/include/laws/bond/each_law.inc CONTENT "${each_law}")
target_include_directories(veriflex_bond PUBLIC $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include/laws>)
install(DIRECTORY ${PROJECT_BINARY_DIR}/include/laws/bond DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/veriflex)
