# The bond laws: one line per law, header = type. Made into bond/laws.hpp.
set(laws
  harmonic=Harmonic
  fene_lj=FeneLj
  shifted_fene=ShiftedFene
)

set(law_includes "")
set(law_types "")
foreach(law IN LISTS laws)
  string(REPLACE "=" ";" law ${law})
  list(GET law 0 header)
  list(GET law 1 type)
  string(APPEND law_includes "#include \"bond/${header}.hpp\"\n")
  list(APPEND law_types ${type})
endforeach()
list(JOIN law_types ", " law_types)
configure_file(${CMAKE_CURRENT_SOURCE_DIR}/bond/laws.hpp.in ${PROJECT_BINARY_DIR}/include/laws/bond/laws.hpp @ONLY)
target_include_directories(veriflex_bond PUBLIC ${PROJECT_BINARY_DIR}/include/laws)
