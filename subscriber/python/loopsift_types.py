# SPDX-License-Identifier: MIT
"""LCM messages from their .lcm definitions, with nothing but the standard library: Debian packages no Python binding.

types = Types("/usr/share/loopsift/msgs")
message = types.decode("loopsift.pose_t", payload)      # a Message: fields as attributes; ValueError on nonsense
payload = types.encode("loopsift.command_t", message)

Wire format: a fingerprint of the type (8 bytes), then the fields in order, big-endian. Arrays of numbers come as
tuples, of bytes as bytes, of messages as lists.
"""
import pathlib
import re
import struct

PRIMITIVES = {"int8_t": "b", "int16_t": "h", "int32_t": "i", "int64_t": "q", "float": "f", "double": "d",
              "byte": "B", "boolean": "b"}
MASK = (1 << 64) - 1


class Message:
    """Fields as attributes."""

    def __init__(self, **fields):
        self.__dict__.update(fields)


def _signed(value):
    return value - (1 << 64) if value >> 63 else value


def _mix(hash_, number):
    return (((hash_ << 8) & MASK) ^ (_signed(hash_) >> 55 & MASK)) + number & MASK


def _mix_text(hash_, text):
    hash_ = _mix(hash_, len(text))
    for character in text.encode():
        hash_ = _mix(hash_, character)
    return hash_


class Type:
    """One struct: its fields (type, name, array sizes) and constants."""

    def __init__(self, package, text):
        self.fields, self.constants = [], {}
        for line in text.split(";"):
            line = line.strip()
            if line.startswith("const"):
                for name, value in re.findall(r"(\w+)\s*=\s*([^,\s]+)", line):
                    self.constants[name] = float(value) if "." in value else int(value, 0)
            elif line:
                kind, name, sizes = re.fullmatch(r"([\w.]+)\s+(\w+)\s*((?:\[\w+\])*)", line).groups()
                if kind not in PRIMITIVES and kind != "string" and "." not in kind:
                    kind = f"{package}.{kind}"
                self.fields.append((kind, name, re.findall(r"\[(\w+)\]", sizes)))


class Types:
    def __init__(self, folder):
        self.types = {}
        for path in sorted(pathlib.Path(folder).glob("*.lcm")):
            text = re.sub(r"//[^\n]*|/\*.*?\*/", "", path.read_text(), flags=re.S)
            package = re.search(r"package\s+([\w.]+)\s*;", text).group(1)
            for name, body in re.findall(r"struct\s+(\w+)\s*\{(.*?)\}", text, flags=re.S):
                self.types[f"{package}.{name}"] = Type(package, body)
        if not self.types:
            raise FileNotFoundError(f"{folder}: no .lcm files")

    def fingerprint(self, name):
        return struct.pack(">Q", self._hash(name, ()))

    def _hash(self, name, parents):
        if name in parents:
            return 0
        hash_ = 0x12345678
        for kind, field, sizes in self.types[name].fields:
            hash_ = _mix_text(hash_, field)
            if kind in PRIMITIVES or kind == "string":
                hash_ = _mix_text(hash_, kind)
            hash_ = _mix(hash_, len(sizes))
            for size in sizes:
                hash_ = _mix_text(_mix(hash_, 0 if size.isdigit() else 1), size)
        for kind, _, _ in self.types[name].fields:
            if kind in self.types:
                hash_ = hash_ + self._hash(kind, (*parents, name)) & MASK
        return (hash_ << 1 | hash_ >> 63) & MASK

    def decode(self, name, data):
        if data[:8] != self.fingerprint(name):
            raise ValueError(f"not a {name}")
        try:
            message, end = self._decode(name, data, 8)
        except (struct.error, IndexError, UnicodeDecodeError) as error:
            raise ValueError(f"{name}: {error}") from error
        if end != len(data):
            raise ValueError(f"{name}: {len(data)} bytes, not {end}")
        return message

    def _decode(self, name, data, at):
        message = Message()
        for kind, field, sizes in self.types[name].fields:
            counts = [int(size) if size.isdigit() else getattr(message, size) for size in sizes]
            if any(count < 0 or count > len(data) for count in counts):
                raise ValueError(f"{name}.{field}: a count of {counts}")
            value, at = self._decode_array(kind, counts, data, at)
            setattr(message, field, value)
        return message, at

    def _decode_array(self, kind, counts, data, at):
        if kind in PRIMITIVES and len(counts) == 1:
            layout = struct.Struct(f">{counts[0]}{PRIMITIVES[kind]}")
            if kind == "byte" and at + counts[0] <= len(data):
                return data[at:at + counts[0]], at + counts[0]
            return layout.unpack_from(data, at), at + layout.size
        if counts:
            values = []
            for _ in range(counts[0]):
                value, at = self._decode_array(kind, counts[1:], data, at)
                values.append(value)
            return values, at
        if kind in PRIMITIVES:
            layout = struct.Struct(">" + PRIMITIVES[kind])
            return layout.unpack_from(data, at)[0], at + layout.size
        if kind == "string":
            (length,) = struct.unpack_from(">i", data, at)
            if length < 1 or at + 4 + length > len(data):
                raise ValueError(f"a text of {length} bytes")
            return data[at + 4:at + 3 + length].decode(), at + 4 + length
        return self._decode(kind, data, at)

    def encode(self, name, message):
        return self.fingerprint(name) + self._encode(name, message)

    def _encode(self, name, message):
        return b"".join(self._encode_array(kind, len(sizes), getattr(message, field))
                        for kind, field, sizes in self.types[name].fields)

    def _encode_array(self, kind, dimensions, value):
        if dimensions:
            return b"".join(self._encode_array(kind, dimensions - 1, element) for element in value)
        if kind in PRIMITIVES:
            return struct.pack(">" + PRIMITIVES[kind], value)
        if kind == "string":
            text = value.encode() + b"\0"
            return struct.pack(">i", len(text)) + text
        return self._encode(kind, value)
