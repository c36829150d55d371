"""Judge everyone in a room of Janus, an open conferencing server, and post the verdicts.

    python 06_judge_a_room.py http://127.0.0.1:8088/janus 1234 --registry sqlite:///people.sqlite3 --post http://…

The agent joins the room and sends nothing.  Each participant's video goes by WebRTC from the server to a process of its
own, without files or keys, and is compared with the badge that the registry has for the name in the room.
"""

import argparse
import json
import secrets
import threading
import urllib.request
from typing import Any

from moireid.errors import MoireIdError
from moireid.registry import claimed, open_registry
from moireid.verifier import Claim
from moireid_studio.watch.order import WatchOrder
from moireid_studio.watch.source import participant
from moireid_studio.watch.watching import Terms, watch

WAIT_S = 40


def post(address: str, content: dict[str, Any]) -> dict[str, Any]:
    """Post JSON, and read the answer's."""
    request = urllib.request.Request(address, json.dumps(content).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=WAIT_S) as answer:
        return dict(json.loads(answer.read() or b"{}"))


class Room:
    """A room of Janus, by its HTTP interface; `handle` is one plug-in handle: the agent's own, or one participant's."""

    def __init__(self, address: str, room: int) -> None:
        made = post(address, {"janus": "create", "transaction": secrets.token_hex(4)})
        self.room, self.session = room, f"{address}/{made['data']['id']}"

    def attach(self) -> int:
        """A new handle."""
        asked = {"janus": "attach", "plugin": "janus.plugin.videoroom", "transaction": secrets.token_hex(4)}
        return int(post(self.session, asked)["data"]["id"])

    def send(self, handle: int, body: dict[str, Any], sdp: str | None = None) -> None:
        """Send a request; what comes of it is an event."""
        asked = {"janus": "message", "transaction": secrets.token_hex(4), "body": body | {"room": self.room}}
        post(f"{self.session}/{handle}", asked | ({"jsep": {"type": "answer", "sdp": sdp}} if sdp else {}))

    def events(self) -> Any:
        """The events of all handles, as they come."""
        while True:
            with urllib.request.urlopen(f"{self.session}?maxev=1", timeout=WAIT_S) as answer:
                event = json.loads(answer.read())
            if event["janus"] == "event":
                yield event["sender"], event["plugindata"]["data"], (event.get("jsep") or {}).get("sdp")


class Agent:
    """Judges each participant for some seconds."""

    def __init__(self, room: Room, registry: str, seconds: float, platform: str | None) -> None:
        self.room, self.registry, self.seconds, self.platform = room, registry, seconds, platform
        self.names: dict[int, str] = {}

    def run(self) -> None:
        """Join, and judge each person who is there or comes."""
        own = self.room.attach()
        self.room.send(own, {"request": "join", "ptype": "publisher", "display": "moireid"})
        for handle, data, offer in self.room.events():
            for one in data.get("publishers", []):
                self.subscribe(one["id"], one.get("display", ""))
            if offer and handle in self.names:
                threading.Thread(target=self.judge, args=(handle, offer), daemon=True).start()

    def subscribe(self, feed: int, name: str) -> None:
        """Ask for a participant's video; the server's offer is an event."""
        handle = self.room.attach()
        self.names[handle] = name
        self.room.send(handle, {"request": "join", "ptype": "subscriber", "streams": [{"feed": feed}]})

    def judge(self, handle: int, offer: str) -> None:
        """Judge one participant, and post the verdict."""
        name = self.names[handle]
        try:
            with open_registry(self.registry, create=False) as registry:
                found = claimed(registry, name)
            # In a call the badge is shown for a while, and not all the time.
            known = {"as_built": found.as_built, "provenance": found.provenance, "cover_share": 0.25}
            claim = Claim(found.badge, found.badge.id, **known)
            order = WatchOrder(participant(name), claim, found.barred)
            start = lambda sdp: self.room.send(handle, {"request": "start"}, sdp)  # noqa: E731
            terms = Terms(self.seconds, offer=offer, answered=start)
            verdict = watch(order, terms, threading.Event(), lambda event: self.post(name, event))
        except MoireIdError as error:
            verdict = {"event": "error", "text": str(error)}
        self.post(name, verdict)

    def post(self, name: str, event: dict[str, Any]) -> None:
        """Send to the platform what is known of a participant so far."""
        why = [one["text"] for one in event.get("reasons", ()) if one["level"] in ("fail", "undecided")]
        said = {"name": name, "event": event["event"], "verdict": event.get("verdict"), "why": event.get("text") or why}
        print(json.dumps(said), flush=True)
        if self.platform:
            post(self.platform, said)


def main() -> None:
    """Judge a room until the program is stopped."""
    wish = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    wish.add_argument("address")
    wish.add_argument("room", type=int)
    wish.add_argument("--registry", required=True)
    wish.add_argument("--seconds", type=float, default=20.0)
    wish.add_argument("--post")
    given = wish.parse_args()
    Agent(Room(given.address, given.room), given.registry, given.seconds, given.post).run()


if __name__ == "__main__":
    main()
