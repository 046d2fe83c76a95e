"""Fuzzes the reader of networks in JSON."""

from fuzz.driver import Target, main
from fuzz.networks import ATTRIBUTES, checked, samples

from gsiirl.scenarios.json_file import read_json

TARGET = Target(
    read=checked(read_json),
    samples=samples(".json"),
    words=[f'"{word}":' for word in (*ATTRIBUTES, "nodes", "edges", "links")] + ["null", "true", "[", "{", "}", "]"],
    package="gsiirl.scenarios",
)

if __name__ == "__main__":
    main(TARGET)
