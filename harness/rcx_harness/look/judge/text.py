"""A judgement in words and as JSON, as `rcx judge` prints it."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime, timezone
from typing import Any

from rcx_harness.look.judge.capture import host_text
from rcx_harness.look.judge.follow import Follower, Times, ordered
from rcx_harness.look.judge.judge import Judgement
from rcx_harness.look.judge.network import Connection, Robot
from rcx_harness.look.judge.ways import Way
from structured_text.output.units import format_us

__all__ = ["as_json", "summary"]

_MOST_CONNECTIONS, _MOST_FINDINGS, _MOST_STRANGERS = 10, 20, 10
_SHARES = {"median": 0.5, "p99": 0.99}
#: Counters of a `Way` with their names in the text. The number of packets is not among them.
_COUNTS = {
    "lost": "lost",
    "doubled": "doubled",
    "late": "out of order",
    "restarts": "times begun anew",
    "cut": "cut off by the capture",
    "wrong": "of a wrong length",
    "stale": "with new data but the sequence count of the packet before",
}


def summary(result: Judgement) -> Iterator[str]:
    """Yield the lines of the summary at the end of a judgement."""
    yield from _file_lines(result)
    robots = {one.number: one for one in result.network.robots.values()} if result.network else {}
    for number, follower in sorted(result.followers.items()):
        yield ""
        robot = robots.get(number)
        yield f"controller {number}" + (f": {host_text(robot.host)}" if robot else "")
        if robot is not None:
            yield from _connection_lines(robot, result.last_us)
        yield from _follower_lines(follower)
    yield ""
    for one in result.findings[:_MOST_FINDINGS]:
        yield f"violation at {one.t_us / 1e6:.6f} s: {one.text}"
    if result.count > _MOST_FINDINGS:
        yield f"... and {result.count - _MOST_FINDINGS} further violations"
    yield f"{result.count or 'no'} violation{'' if result.count == 1 else 's'}"


def as_json(result: Judgement) -> dict[str, Any]:
    """Return the result as a JSON object; times are microseconds from the first packet."""
    robots = {one.number: one for one in result.network.robots.values()} if result.network else {}
    found: dict[str, Any] = {"file": str(result.file), "length_us": result.last_us}
    if result.capture is not None and result.network is not None:
        found |= {
            "begin": _begin(result),
            "packets": result.capture.packets,
            "cyclic_packets": result.network.cyclic,
            "not_read": dict(result.capture.others),
            "cut_off": result.capture.damage,
            "not_judged": [
                {
                    "from": host_text(one.source),
                    "to": host_text(one.destination),
                    "bytes": one.length,
                    "packets": one.packets,
                    "why": one.text,
                }
                for one in result.network.strangers.values()
                if one.packets
            ],
        }
    found["controllers"] = [
        {
            "number": number,
            **(_robot_json(robots[number]) if number in robots else {}),
            "commands": follower.commands,
            "gaps": follower.gaps,
            "data_with_code": follower.together,
            "times": {name: _times_json(times) for name, times in ordered(follower.times)},
        }
        for number, follower in sorted(result.followers.items())
    ]
    found["violation_count"] = result.count
    found["violations"] = [
        {"t_us": one.t_us, "rule": one.rule, "text": one.text} for one in result.findings
    ]
    return found


def _begin(result: Judgement) -> str:
    begin_us = result.capture.begin_us if result.capture else None
    if begin_us is None:
        return ""
    return datetime.fromtimestamp(begin_us / 1e6, timezone.utc).isoformat(" ", "milliseconds")


def _file_lines(result: Judgement) -> Iterator[str]:
    capture, network = result.capture, result.network
    if capture is None or network is None:
        by = result.header.get("by", "rcx run")
        yield f"{result.file.name}: a trace of {by}, {result.last_us / 1e6:.3f} s"
        return
    yield (
        f"{result.file.name}: {capture.packets} packets, {network.cyclic} of class 1, "
        f"{result.last_us / 1e6:.3f} s from {_begin(result)}"
    )
    for what, count in capture.others.most_common():
        yield f"  not read: {count} {what}"
    if network.streams.gaps:
        yield f"  TCP: {network.streams.gaps} times segments are missing"
    if network.unreadable:
        yield f"  {network.unreadable} requests to the connection manager cannot be read"
    strangers = [one for one in network.strangers.values() if one.packets]
    for one in strangers[:_MOST_STRANGERS]:
        ends = f"{host_text(one.source)} to {host_text(one.destination)}"
        yield f"  not judged: {one.packets} packets from {ends}, {one.length} bytes: {one.text}"
    if len(strangers) > _MOST_STRANGERS:
        yield f"  ... and those of {len(strangers) - _MOST_STRANGERS} further directions"


def _connection_lines(robot: Robot, end_us: int) -> Iterator[str]:
    for one in robot.connections[:_MOST_CONNECTIONS]:
        begin = f"from {one.begin_us / 1e6:.3f} s"
        if not one.opened:
            begin = "open before the capture began"
        yield (
            f"  {one.kind.value} {host_text(one.peer)}, {robot.size} bytes, {begin}, "
            f"{_end_text(one, end_us)}"
        )
        yield f"    to the controller {_way_text(one.to_robot, one.to_robot_us)}"
        yield f"    from it {_way_text(one.to_master, one.to_master_us)}"
    if len(robot.connections) > _MOST_CONNECTIONS:
        yield f"  ... and {len(robot.connections) - _MOST_CONNECTIONS} further connections"


def _end_text(one: Connection, end_us: int) -> str:
    if one.end:
        return f"{one.end} at {one.end_us / 1e6:.3f} s"
    for way in (one.to_robot, one.to_master):
        if way.packets and 0 < way.timeout_us < end_us - way.last_us:
            return f"silent from {way.last_us / 1e6:.3f} s on"
    return "open to the end"


def _way_text(way: Way, api_us: int) -> str:
    every = f"every {format_us(api_us)}, " if api_us else ""
    counts = [f"{value} {text}" for name, text in _COUNTS.items() if (value := getattr(way, name))]
    text = ", ".join([f"{every}{way.packets} packets", *(counts or ["none lost"])])
    return f"{text}; longest silence {format_us(way.longest_us)}" if way.packets > 1 else text


def _follower_lines(follower: Follower) -> Iterator[str]:
    yield f"  {follower.commands} remote command{'' if follower.commands == 1 else 's'}"
    if follower.gaps:
        text = "the areas have changed across missing packets; no rule was checked there"
        yield f"  {follower.gaps} times {text}"
    if follower.together:
        text = "new data arrived with the code, so their order is unknown"
        yield f"  {follower.together} times {text}"
    if not follower.times:
        return
    width = max(14, *(len(name) for name in follower.times))
    heads = "".join(f"{name:>12}" for name in (*_SHARES, "longest"))
    yield f"  {'response times':<{width}}{'count':>8}{heads}"
    for name, times in ordered(follower.times):
        about = "" if times.exact else "~"
        every = [about + format_us(times.percentile_us(share)) for share in _SHARES.values()]
        every.append(format_us(times.longest_us))
        shown = "".join(f"{one:>12}" for one in every) if times.count else ""
        missing = f"  {times.open} without an answer" if times.open else ""
        yield f"  {name:<{width}}{times.count:>8}{shown}{missing}"


def _robot_json(robot: Robot) -> dict[str, Any]:
    return {
        "address": host_text(robot.host),
        "size": robot.size,
        "connections": [
            {
                "peer": host_text(one.peer),
                "kind": one.kind.value,
                "begin_us": one.begin_us,
                "forward_open": one.opened,
                "end": one.end,
                "end_us": one.end_us if one.end else None,
                "to_controller": _way_json(one.to_robot, one.to_robot_us),
                "from_controller": _way_json(one.to_master, one.to_master_us),
            }
            for one in robot.connections
        ],
    }


def _way_json(way: Way, api_us: int) -> dict[str, int]:
    counts = {name: getattr(way, name) for name in ("packets", *_COUNTS)}
    return {"interval_us": api_us, **counts, "longest_silence_us": way.longest_us}


def _times_json(times: Times) -> dict[str, Any]:
    shares = {f"{name}_us": times.percentile_us(share) for name, share in _SHARES.items()}
    counts = {"count": times.count, "unanswered": times.open, "exact": times.exact}
    return {**counts, **shares, "longest_us": times.longest_us}
