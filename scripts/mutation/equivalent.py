"""Generated mutants that survived, of which nobody could see anything: file, what stood there, what took its place, and why nothing follows."""

EQUIVALENT = [
]
