#!/usr/bin/env python3
"""Counts `unsafe` in the crates of a Cargo.lock, in exactly the versions that it names.

    unsafe-count.py                     the crates on the data path (the list below), as a Markdown table
    unsafe-count.py --all               every crate of the lock file
    unsafe-count.py zenoh tokio         these
    --lock FILE     another lock file than ./Cargo.lock
    --built DIR     counts only source files that a build compiled, by the dep-info files there (target/debug/deps)

Comments, strings and test code (`#[cfg(test)]`, `#[test]`, folders of tests, benches and examples) do not count. What a
compiled file switches off by `cfg` inside itself does count: the figures are upper bounds. Needs no network: the sources
are where Cargo unpacked them, so run `cargo fetch` first.
"""

import argparse
import os
import re
import sys
import tomllib
from pathlib import Path

# What a frame passes between the cycle threads of two nodes, and what decides who may send one.
DATA_PATH = """
zenoh zenoh-transport zenoh-link zenoh-link-commons zenoh-link-tcp zenoh-link-udp zenoh-link-unixsock_stream
zenoh-link-quic zenoh-link-quic_datagram zenoh-link-tls zenoh-buffers zenoh-codec zenoh-collections zenoh-protocol
zenoh-keyexpr zenoh-sync zenoh-runtime zenoh-task zenoh-core zenoh-result zenoh-util zenoh-config zenoh-crypto
ringbuffer-spsc arc-swap flume event-listener uhlc
tokio tokio-util mio socket2 bytes futures-util futures-channel
rustls tokio-rustls rustls-webpki rustls-pki-types ring untrusted subtle zeroize x509-parser
quinn quinn-proto quinn-udp lru-slab slab
rtrb memmap2 rustix linux-raw-sys nix libc postcard cobs crc32fast hmac sha2
""".split()

TOKENS = re.compile(
    r"""
      (?P<line_comment>//[^\n]*)
    | (?P<block_comment>/\*)
    | (?P<raw_string>(?:br|cr|r)(?P<hashes>\#*)")
    | (?P<string>[bc]?"(?:\\.|[^"\\])*")
    | (?P<char>b?'(?:\\(?:x[0-9a-fA-F]{2}|u\{[^}]*\}|.)|[^'\\\n])')
    | (?P<word>(?:r\#)?[A-Za-z_][A-Za-z0-9_]*)
    | (?P<sign>[^\s])
    """,
    re.VERBOSE | re.DOTALL,
)


def tokens(text):
    """The words and signs of Rust source, without comments, strings and characters."""
    at, found = 0, []
    while match := TOKENS.search(text, at):
        at = match.end()
        if match["block_comment"]:
            at = end_of_block_comment(text, at)
        elif match["raw_string"]:
            end = text.find('"' + match["hashes"], at)
            at = len(text) if end < 0 else end + 1 + len(match["hashes"])
        elif match["string"]:
            found.append('""')
        elif match["word"] or match["sign"]:
            found.append(match[0])
    return found


def end_of_block_comment(text, at):
    """Block comments nest."""
    depth = 1
    while depth:
        match = re.compile(r"/\*|\*/").search(text, at)
        if not match:
            return len(text)
        depth += 1 if match[0] == "/*" else -1
        at = match.end()
    return at


def end_of_group(words, at):
    """The index behind the bracket that closes the one at `at`."""
    depth = 0
    for index in range(at, len(words)):
        if words[index] in "([{":
            depth += 1
        elif words[index] in ")]}":
            depth -= 1
            if depth == 0:
                return index + 1
    return len(words)


def without_tests(words):
    """Leaves out each item behind `#[cfg(test)]` or `#[test]`."""
    kept, at = [], 0
    while at < len(words):
        if words[at] == "#" and at + 1 < len(words) and words[at + 1] == "[":
            end = end_of_group(words, at + 1)
            if is_test(words[at + 2 : end - 1]):
                at = end_of_item(words, end)
                continue
            kept += words[at:end]
            at = end
        else:
            kept.append(words[at])
            at += 1
    return kept


def is_test(attribute):
    if attribute[:1] == ["cfg"]:
        return "test" in attribute and "not" not in attribute and "any" not in attribute
    return attribute == ["test"] or attribute[-3:] == [":", ":", "test"]


# What begins an item; elsewhere, a comma ends what an attribute stands before: a field, an arm, an argument.
ITEMS = set("pub fn impl mod struct enum union trait use type const static unsafe async extern macro_rules".split())


def end_of_item(words, at):
    """Behind the item that begins at `at`: its block, its semicolon or its comma."""
    while at < len(words) and words[at] == "#":
        at = end_of_group(words, at + 1)
    ends = ";" if words[at : at + 1] and words[at] in ITEMS else ";,"
    while at < len(words):
        if words[at] == "{":
            return end_of_group(words, at)
        if words[at] in "([":
            at = end_of_group(words, at)
        elif words[at] in ends:
            return at + 1
        elif words[at] == "}":
            return at
        else:
            at += 1
    return at


def count(words):
    """Blocks, functions and implementations that are `unsafe`."""
    blocks = functions = implementations = 0
    for at, word in enumerate(words):
        if word != "unsafe":
            continue
        after = words[at + 1 : at + 5]
        if after[:1] == ["{"]:
            blocks += 1
        elif after[:1] in (["impl"], ["trait"]):
            implementations += 1
        elif "fn" in after[:1] or (after[:1] == ["extern"] and "fn" in after and "{" not in after):
            # `unsafe extern "C" fn(…)` and `unsafe fn(…)` without a name are types.
            name = after.index("fn") + 1
            functions += name < len(after) and after[name] != "("
        elif after[:1] == ["extern"]:
            blocks += 1
    return blocks, functions, implementations


def sources(crate, lock_folder):
    """The folder of a crate's source: Cargo's registry, or a folder of the workspace."""
    if "source" not in crate:
        for manifest in sorted(lock_folder.glob("**/Cargo.toml")):
            if "target" not in manifest.relative_to(lock_folder).parts[:1]:
                if tomllib.loads(manifest.read_text()).get("package", {}).get("name") == crate["name"]:
                    return manifest.parent
        return None
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    found = sorted(home.glob(f"registry/src/*/{crate['name']}-{crate['version']}"))
    return found[0] if found else None


def compiled(folder):
    """The source files that the dep-info files of a build name."""
    files = set()
    for info in Path(folder).glob("*.d"):
        for line in info.read_text(errors="replace").splitlines():
            if line.endswith(".rs:"):
                files.add(Path(line[:-1].replace("\\ ", " ")).resolve())
    return files


def files_of(folder, built):
    skipped = {"tests", "benches", "examples", "target"}
    for file in sorted(folder.glob("**/*.rs")):
        inside = file.relative_to(folder)
        if inside.parts[0] in skipped or inside.name == "build.rs" or "tests" in inside.parts:
            continue
        if inside.stem in {"test", "tests"} or inside.stem.endswith(("_test", "_tests")):
            continue
        if built is None or file.resolve() in built:
            yield file


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("crates", nargs="*")
    options.add_argument("--all", action="store_true")
    options.add_argument("--lock", default="Cargo.lock")
    options.add_argument("--built")
    given = options.parse_args()

    lock = Path(given.lock).resolve()
    crates = tomllib.loads(lock.read_text())["package"]
    wanted = given.crates or DATA_PATH
    if missing := sorted(set(wanted) - {crate["name"] for crate in crates}):
        sys.exit(f"not in {lock.name}: {', '.join(missing)}")
    order = {name: index for index, name in enumerate(wanted)}
    chosen = [crate for crate in crates if given.all or crate["name"] in order]
    chosen.sort(key=lambda crate: (order.get(crate["name"], 0), crate["name"], crate["version"]))
    built = compiled(given.built) if given.built else None

    print("| crate | version | files | blocks | fns | impls | remark |")
    print("| --- | --- | --: | --: | --: | --: | --- |")
    total = [0, 0, 0, 0]
    for crate in chosen:
        folder = sources(crate, lock.parent)
        if folder is None:
            print(f"| {crate['name']} | {crate['version']} | | | | | no source: run cargo fetch |")
            continue
        figures, forbids = [0, 0, 0, 0], False
        for file in files_of(folder, built):
            text = file.read_text(errors="replace")
            forbids |= bool(re.search(r"#!\[forbid\([^)]*unsafe_code", text))
            figures = [a + b for a, b in zip(figures, (1, *count(without_tests(tokens(text)))))]
        if built is not None and figures[0] == 0:
            remark = "not in this build"
        elif forbids:
            remark = "forbids it"
        else:
            remark = "" if "source" in crate else "ours"
        total = [a + b for a, b in zip(total, figures)]
        print(f"| {crate['name']} | {crate['version']} | {' | '.join(map(str, figures))} | {remark} |")
    print(f"| all | | {' | '.join(map(str, total))} | |")


if __name__ == "__main__":
    main()
