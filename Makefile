# Two commands: `make verify` (verdicts and a report), `make test` (unit tests and the quick tier).
# Everything else is CMake's: cmake --preset release, ctest --preset quick, ...

.PHONY: verify test build deps clean

verify: build
	@cmake --build --preset release --target verify

test: build
	@ctest --preset test

build: deps
	@cmake --preset release >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@cmake --build --preset release

deps:
	@scripts/install-deps
	@mkdir -p build

clean:
	rm -rf build
