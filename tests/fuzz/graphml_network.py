"""Fuzzes the reader of networks in GraphML."""

from fuzz.driver import Target, main
from fuzz.networks import ATTRIBUTES, checked, samples

from gsiirl.scenarios.graphml_file import read_graphml

TARGET = Target(
    read=checked(read_graphml),
    samples=samples(".graphml", ".xml"),
    words=[f'attr.name="{word}"' for word in ATTRIBUTES]
    + [f'attr.type="{word}"' for word in ("double", "int", "boolean", "string")]
    + [f"<{word}>" for word in ("key", "graph", "node", "edge", "data", "default", "hyperedge", "/data", "/node")]
    + [
        'yfiles.foldertype="group"',
        'directed="false"',
        'edgedefault="undirected"',
        'for="edge"',
        "<!DOCTYPE x [",
        "&amp;",
    ],
    package="gsiirl.scenarios",
)

if __name__ == "__main__":
    main(TARGET)
