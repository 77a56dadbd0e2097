# Three commands: `make verify` (verdicts and a report; TIER=full for the long cases), `make test` (unit tests and the quick tier), `make bench` (what
# the hot loops cost on this machine, as JSON in build/bench; no verdict; BOX=64x416x400 STORAGE=float measures that fluid
# alone). And `make mutants`: would these notice bugs? Two hours, of which MINUTES=60 for generated ones (docs/MUTANTS.md).
# Everything else is CMake's: cmake --preset release, ctest --preset quick, ...

.PHONY: verify test bench mutants configure deps clean

verify: configure
	@cmake --build --preset release --target veriflex
	@scripts/verify build/release $(TIER)

test: configure
	@cmake --build --preset release
	@ctest --preset test

bench: configure
	@mkdir -p build/bench
	@cmake --build --preset release --target veriflex_solid_bench veriflex_fluid_bench veriflex_filament_bench
	@build/release/veriflex_fluid_bench --output build/bench/fluid.json $(if $(BOX),--box $(BOX)) $(if $(STORAGE),--storage $(STORAGE))
ifeq ($(BOX)$(STORAGE),)
	@build/release/veriflex_filament_bench --output build/bench/filament.json
	@build/release/veriflex_solid_bench --benchmark_out=build/bench/solid.json --benchmark_out_format=json
endif

mutants: deps
	@cmake --preset mutants >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@cmake --build --preset mutants
	@scripts/mutants planted; planted=$$?; scripts/mutants generated --minutes $(or $(MINUTES),60) && exit $$planted

# Who builds once has eight files compiled as one, in half of the time; `cmake --preset release` before it keeps them apart,
# as one wants who changes them.
configure: deps
	@cmake --preset release $(if $(wildcard build/release/CMakeCache.txt),,-DCMAKE_UNITY_BUILD=ON) >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }

deps:
	@scripts/install-deps
	@mkdir -p build

clean:
	rm -rf build
