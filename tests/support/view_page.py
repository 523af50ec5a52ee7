"""Reader for the data in a page of `rcx view`. The head of pack.py describes their format."""

from __future__ import annotations

import base64
import json
import re
import struct
import zlib
from collections.abc import Iterator
from typing import Any

Change = tuple[int, Any]


class PageContent:
    """The data of a page of `rcx view`: its table, and the changes of its lanes."""

    def __init__(self, page: str) -> None:
        found = re.search(r'<script id="data" type="text/plain">(.*?)</script>', page)
        assert found is not None
        data = zlib.decompress(base64.b64decode(found[1]))
        (length,) = struct.unpack_from("<I", data)
        self.table: dict[str, Any] = json.loads(data[4 : 4 + length])
        self._bytes = data[4 + length :]
        self._at = 0

    def _whole(self) -> int:
        value = shift = 0
        while True:
            byte = self._bytes[self._at]
            self._at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def lane(self, name: str) -> dict[str, Any]:
        """Return the table's entry for the first lane with this name."""
        return next(one for one in self.table["lanes"] if one["name"] == name)

    def changes(self, name: str) -> list[Change]:
        """Return the initial value of a lane, at time -1, and its changes."""
        lane = self.lane(name)
        self._at, end = lane["at"][0], sum(lane["at"])
        first = lane["first"]
        if lane["form"] == "text" and first is not None:
            first = self.table["texts"][first]
        found = [(-1, first), *self._changes(lane, lane["first"])]
        assert self._at == end
        return found

    def _changes(self, lane: dict[str, Any], value: Any) -> Iterator[Change]:
        t_us = 0
        for _ in range(lane["count"]):
            t_us += self._whole()
            if lane["form"] == "bit":
                value = 1 - value
            elif lane["form"] == "whole":
                by = self._whole()
                value += -(by + 1) // 2 if by % 2 else by // 2
            elif lane["form"] == "real":
                (value,) = struct.unpack_from("<d", self._bytes, self._at)
                self._at += 8
            else:
                value = self.table["texts"][self._whole()]
            yield t_us, value

    def order(self) -> list[str]:
        """Return the lane name of each event, in the order of the events."""
        self._at = self.table["order"]["at"]
        count = self.table["order"]["count"]
        return [self.table["lanes"][self._whole()]["name"] for _ in range(count)]

    def groups(self) -> dict[str, list[str]]:
        """Return the names of the lanes of each group."""
        names = [one["name"] for one in self.table["lanes"]]
        return {one["title"]: [names[k] for k in one["lanes"]] for one in self.table["groups"]}
