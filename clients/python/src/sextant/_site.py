"""A site that this program is connected to."""

from __future__ import annotations

import os
import re
import threading
import weakref
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import lru_cache
from time import monotonic, sleep
from typing import Any, Callable, Optional, Sequence, TypeVar, Union

import zenoh

from ._arrays import matrix, vector
from ._changes import POLL_S, Model, answer_to, key_of, signature
from ._command import Command, Word, options
from ._epochs import EpochFilter
from ._estimates import relative_pose, worse
from ._history import History
from ._messages import (
    Camera,
    CameraSettings,
    CameraStatus,
    ConfigAnswer,
    ConfigAnswerOutcomeRefused,
    FusionStatus,
    ObjectConfig,
    ObjectPose,
    Observations,
    Proposal,
    RigConfig,
    State,
)
from ._network import open_session, role_of
from ._pose import Pose, Transform
from ._recorder import Recording
from ._subscription import Subscription
from ._wire import MAX_BYTES, VERSION, decode, encode
from .errors import (
    ClosedError,
    DecodeError,
    InvalidNameError,
    NoFusionError,
    NoPoseError,
    NoRouterError,
    OptionsError,
    RefusedError,
    SextantError,
    UnknownNameError,
)

T = TypeVar("T")

DEFAULT_PORT = 7447
#: How long nodes may take to answer what they published last, s.
_ANSWER_S = 1.0
#: Between two looks for a fusion node that still starts, s.
_PAUSE_S = 0.2
_RECONNECTING = "the connection is being made again"
_ID = re.compile(r"[a-z0-9_-]{1,32}")


#: Sites that were not closed yet.
_OPEN: weakref.WeakSet[Site] = weakref.WeakSet()


def _close_all_at_the_end() -> None:
    """Zenoh calls back on threads for which the interpreter waits before anything else at its end, so that it would
    wait for ever.
    """
    threading.main_thread().join()
    with ExitStack() as sites:
        for site in list(_OPEN):
            sites.callback(site.close)


@lru_cache(maxsize=None)
def _watch_for_the_end() -> None:
    threading.Thread(target=_close_all_at_the_end, name="sextant-end").start()


@dataclass(frozen=True)
class ObjectInfo:
    """An object of the site."""

    #: Its name.
    id: str
    #: How much its pose can be trusted; none before a fusion node's first status.
    state: Optional[State]
    #: Poses per second over the last seconds.
    rate_hz: float
    #: Its tags, links and joints.
    config: ObjectConfig


@dataclass(frozen=True)
class CameraInfo:
    """A camera of the site."""

    #: Its name.
    id: str
    #: Whether its node runs.
    is_alive: bool
    #: Its lens and pose in the rig; none of a camera that the rig lacks.
    config: Optional[Camera]
    #: What its node reports; none while it does not run.
    status: Optional[CameraStatus]


@dataclass(frozen=True, order=True)
class Node:
    """A process of the site."""

    #: camera, fusion or viewer.
    kind: str
    #: Its name.
    id: str


def connect(
    endpoint: Union[str, Sequence[str], None] = None,
    site: str = "demo",
    *,
    keys: Union[str, os.PathLike[str], None] = None,
    user: Optional[str] = None,
    password: Optional[str] = None,
    timeout: float = 5.0,
) -> Site:
    """Connects to a site.

    `endpoint` is the router's, `tcp/<address>:<port>` or, with keys, `quic/<address>:<port>`; of several the first that
    answers is used, and each has an equal share of `timeout`. Default: port 7447 of this machine. `keys` is the folder
    that `sextant keys add` makes for a viewer or an operator of a protected site; `user` and `password` take its place
    in the profile lab. `timeout` is how long connecting may take, and how long to wait for a fusion node that still
    starts, in seconds.
    """
    _check_id("site", site)
    if endpoint is None:
        protocol = "tcp" if keys is None else "quic"
        endpoint = f"{protocol}/127.0.0.1:{DEFAULT_PORT}"
    endpoints = [endpoint] if isinstance(endpoint, str) else list(endpoint)
    session = open_session(endpoints, site, keys, user, password, timeout)
    return Site(session, site, timeout, Access(endpoints, keys, user))


@dataclass(frozen=True)
class Access:
    """How this program has come to the site, for commands that go the same way."""

    endpoints: Sequence[str]
    keys: Union[str, os.PathLike[str], None]
    user: Optional[str]

    def words(self, site: str, session: Any) -> list[str]:
        if self.user is not None:
            raise OptionsError(
                "commands need keys where the site is protected: connect with keys=DIR instead of user and password"
            )
        keys = [] if self.keys is None else ["--keys", os.fspath(self.keys)]
        return ["--connect", self._endpoint(session), "--site", site, *keys, "--until-input-ends"]

    def _endpoint(self, session: Any) -> str:
        """The endpoint that answers."""
        if len(self.endpoints) == 1:
            return self.endpoints[0]
        connected = [link.dst for link in session.info.links()]
        if not connected:
            raise NoRouterError(self.endpoints, _RECONNECTING)
        # The certificate of a quic endpoint may be for its name, which the link does not tell.
        if connected[0] not in self.endpoints and connected[0].startswith("quic/"):
            raise OptionsError(
                f"commands cannot tell which of {', '.join(self.endpoints)} has answered: connect to one of them"
            )
        return str(connected[0])

    def check_may_change(self) -> None:
        """The router enforces this as well, but drops the message without an answer."""
        role = None if self.keys is None else role_of(self.keys)
        if role not in (None, "operator", "fusion"):
            raise OptionsError(f"keys of the role {role} may not change the site: connect with those of an operator")


class Site:
    """A connection to a site, made by `connect`; use it in a `with` statement, or call `close`.

    A connection that breaks is made again without help, and subscriptions go on. Methods may be called from any thread;
    those that wait say for how long.
    """

    def __init__(self, session: Any, site: str, timeout: float, access: Access) -> None:
        self._session = session
        self._access = access
        self._root = f"sextant/v{VERSION}/{site}"
        self._timeout = timeout
        self._followed: dict[str, tuple[History, Any]] = {}
        #: What ends with the site.
        self._dependents: weakref.WeakSet[Union[Subscription[Any], Command, Recording]] = weakref.WeakSet()
        self._lock = threading.Lock()
        #: The name of the site.
        self.name = site
        _OPEN.add(self)
        _watch_for_the_end()

    def __enter__(self) -> Site:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is None:
            self.close()
        else:
            # The first error matters more.
            with suppress(Exception):
                self.close()

    def __repr__(self) -> str:
        return f"Site({self.name!r}, {'connected' if self.is_connected else 'not connected'})"

    def close(self) -> None:
        """Closes the connection, and ends its subscriptions, recordings and calibrations, and whatever waits for a
        pose.

        Raises `CommandError` where a recording failed, after everything is closed.
        """
        with self._lock:
            session, self._session = self._session, None
            dependents = list(self._dependents)
        errors = []
        try:
            for history, _ in self._followed.values():
                history.close()
            for dependent in dependents:
                try:
                    dependent.close()
                except Exception as error:
                    errors.append(error)
        finally:
            if session is not None:
                session.close()
        if errors:
            raise errors[0]

    @property
    def is_connected(self) -> bool:
        """Whether the router answers now. While it does not, the connection is being made again."""
        session = self._session
        return session is not None and bool(session.info.routers_zid())

    def objects(self) -> dict[str, ObjectInfo]:
        """The objects by name. Waits for a second at most."""
        # Nodes that stand by publish no poses: what an object's publisher reports comes last and counts.
        statuses = sorted(self.statuses(), key=lambda status: status.epoch or 0)
        reported = [health for status in statuses for health in status.objects]
        healths = {health.object: health for health in sorted(reported, key=lambda health: health.rate_hz)}
        found = {}
        for config in self._latest("config/object/*", ObjectConfig):
            health = healths.get(config.id)
            # Without tags it is an object that was removed.
            if config.tags:
                state, rate_hz = (health.state, health.rate_hz) if health else (None, 0.0)
                found[config.id] = ObjectInfo(config.id, state, rate_hz, config)
        return found

    def cameras(self) -> dict[str, CameraInfo]:
        """The cameras of the rig and those whose node runs, by name. Waits for a few seconds at most."""
        configs = {camera.id: camera for rig in self._latest("config/rig", RigConfig) for camera in rig.cameras}
        statuses = {status.camera: status for status in self._latest("camera/*/status", CameraStatus)}
        alive = {node.id for node in self.nodes() if node.kind == "camera"}
        names = sorted(configs.keys() | statuses.keys() | alive)
        return {name: CameraInfo(name, name in alive, configs.get(name), statuses.get(name)) for name in names}

    def nodes(self) -> list[Node]:
        """The processes that run. Waits for a second at most."""
        keys = self._alive(f"{self._root}/alive/*/*")
        return sorted({Node(*key.split("/")[-2:]) for key in keys})

    def statuses(self) -> list[FusionStatus]:
        """The newest status of each fusion node: cameras, objects, faults and notices. Waits for a second at most."""
        return self._latest("fusion/*/status", FusionStatus)

    def rig(self) -> RigConfig:
        """The cameras that are in force. Waits for a fusion node that still starts."""
        deadline = monotonic() + self._timeout
        while True:
            for rig in self._latest("config/rig", RigConfig):
                return rig
            if monotonic() >= deadline:
                raise self._no_fusion()
            sleep(_PAUSE_S)

    def proposal(self) -> Optional[Proposal]:
        """The refined calibration that a fusion node proposes, if any; `set` puts it in force."""
        proposals = self._latest("fusion/*/proposal", Proposal)
        return next((proposal for proposal in proposals if proposal.rig or proposal.objects), None)

    def former(self) -> Optional[Proposal]:
        """What was in force before the last change, if it is known; `set` takes the change back with it."""
        statuses = self.statuses()
        if not statuses:
            raise self._no_fusion()
        node = max(statuses, key=lambda status: status.epoch or 0).node
        formers = self._latest(f"fusion/{node}/former", Proposal)
        return next((former for former in formers if former.rig or former.objects), None)

    def set(self, *models: Model) -> ConfigAnswer:
        """Puts models in force: a rig, an object, settings of a camera, a proposal; or a rig and objects together.

        All of it is put in force, or none. Raises `RefusedError` with the cause where the fusion node refuses it, and
        `NoAnswerError` where none answers within 15 s. What a model leaves out is not given any more.
        """
        self._access.check_may_change()
        fusion = [node for node in self.nodes() if node.kind == "fusion"]
        if not fusion:
            raise self._no_fusion()
        model = models[0] if len(models) == 1 else _together(fusion[0].id, models)
        if isinstance(model, ObjectConfig):
            _check_id("object", model.id)
        if isinstance(model, CameraSettings):
            _check_id("camera", model.camera)
        key, payload = f"{self._root}/{key_of(model)}", encode(model)

        def ask() -> None:
            self._open().put(key, payload, attachment=signature(), congestion_control=zenoh.CongestionControl.BLOCK)

        def read(_: str, payload: bytes) -> ConfigAnswer:
            answer: ConfigAnswer = decode(payload, ConfigAnswer)
            return answer

        answers = "fusion/*/answer"
        with self._subscribe(answers, read, POLL_S, TimeoutError) as subscription:
            answer = answer_to(payload, ask, subscription, lambda: self._latest(answers, ConfigAnswer))
        if isinstance(answer.outcome, ConfigAnswerOutcomeRefused):
            raise RefusedError(answer.node, answer.outcome.value)
        return answer

    def remove_object(self, name: str) -> ConfigAnswer:
        """Removes an object. Raises as `set`."""
        self._check_object(name)
        return self.set(
            ObjectConfig(name, links=(), joints=(), tags=(), frame_sigma=None, scale_sigma=None, world_from_object=None)
        )

    def record(
        self,
        file: Union[str, os.PathLike[str]],
        *,
        images: bool = False,
        objects: Union[str, Sequence[str]] = (),
        camera_config: Union[str, os.PathLike[str], None] = None,
        force: bool = False,
    ) -> Recording:
        """Records the site into an MCAP file, by `sextant record`, whose options these are; use it in a `with`
        statement.

        It has begun when this returns. Raises `CommandError`, such as for a file that exists without `force`.
        """
        names = [objects] if isinstance(objects, str) else list(objects)
        given = options({"images": images, "object": names, "camera_config": camera_config, "force": force})
        command = self._command(["record", file, *given])
        recording = Recording(os.fspath(file), command)
        with self._lock:
            # Where the site was closed in the meantime, so was the command.
            self._open()
            self._dependents.discard(command)
            self._dependents.add(recording)
        return recording

    def poses(self, name: Optional[str] = None, *, timeout: Optional[float] = None) -> Subscription[Pose]:
        """The poses of an object from now on, for `for` and `async for`; of all objects without a name.

        With a `timeout` it raises `NoPoseError` when no pose came for so many seconds.
        """
        if name is not None:
            self._check_object(name)
        read = self._pose_reader()

        def pose(key: str, payload: bytes) -> Optional[Pose]:
            message = read(key, payload)
            return None if message is None else Pose.from_message(message)

        return self._subscribe(f"object/{name or '*'}/pose", pose, timeout, self._silence(name or "any object"))

    def observations(self, camera: str, *, timeout: Optional[float] = None) -> Subscription[Observations]:
        """What each image of a camera shows, from now on, for `for` and `async for`."""
        _check_id("camera", camera)
        known = self.cameras()
        if camera not in known:
            raise UnknownNameError("camera", camera, self.name, known)
        read = self._reader("camera", "observations", Observations)
        return self._subscribe(f"camera/{camera}/observations", read, timeout, self._silence(camera))

    def pose(self, name: str, timeout: float = 5.0) -> Pose:
        """The pose of an object now: the newest one, if it arrived within the last second; otherwise the next.

        Raises `UnknownNameError`, or `NoPoseError` when none arrives within `timeout` seconds.
        """
        started = monotonic()
        return Pose.from_message(self._newest(name, started, started + timeout))

    def pose_at(self, name: str, t_ns: int, timeout: float = 5.0) -> Pose:
        """The pose of an object at a time, interpolated, with a covariance that allows for what happened in between.

        Waits for a pose after that time. Poses are kept for 10 s, from the first request for this object.
        Raises `NoPoseError` for a time without poses around it.
        """
        deadline = monotonic() + timeout
        return Pose.from_message(self._follow(name).at(name, t_ns, deadline))

    def transform(self, a: str, b: str, timeout: float = 5.0, *, t_ns: Optional[int] = None) -> Transform:
        """Where object `b` is in the frame of object `a`: at `t_ns`, or at the newest time at which both are known.

        Raises as `pose_at`.
        """
        started = monotonic()
        deadline = started + timeout
        histories = [self._follow(a), self._follow(b)]
        if t_ns is None:
            newest_ns = min(self._newest(name, started, deadline).capture_ns for name in (a, b))
            # A history that has only begun may begin after the other's newest pose, which then has to wait for the
            # next.
            t_ns = max(newest_ns, *(history.oldest_ns() for history in histories))
        poses = [history.at(name, t_ns, deadline) for name, history in zip((a, b), histories)]
        return _transform(*poses)

    def _newest(self, name: str, started: float, deadline: float) -> ObjectPose:
        history = self._follow(name)
        pose = history.newest(deadline)
        if pose is None:
            raise self._no_pose(name, monotonic() - started, history.silent_s())
        return pose

    def _no_pose(self, name: str, waited: float, silent_s: Optional[float] = None) -> NoPoseError:
        last = "" if silent_s is None else f", the last one came {silent_s:.1f} s ago"
        why = "check that cameras see it (`sextant top`)" if self.is_connected else "the router is out of reach"
        return NoPoseError(f"no pose of {name!r} within {waited:.1f} s{last}: {why}")

    def _silence(self, name: str) -> Callable[[float], Exception]:
        return lambda waited: self._no_pose(name, waited)

    def _command(self, arguments: Sequence[Word]) -> Command:
        """Runs a command on this site, which ends where the site is closed before."""
        with self._lock:
            command = Command(arguments, self._access.words(self.name, self._open()))
            self._dependents.add(command)
        return command

    def _follow(self, name: str) -> History:
        """The history of an object, which begins with the first request."""
        followed = self._followed.get(name)
        if followed is not None:
            return followed[0]
        self._check_object(name)
        history = History()
        read = self._pose_reader()

        def take_in(sample: Any) -> None:
            try:
                pose = read(str(sample.key_expr), bytes(sample.payload))
            except DecodeError:
                return
            if pose is not None:
                history.insert(pose)

        with self._lock:
            if name not in self._followed:
                subscriber = self._open().declare_subscriber(f"{self._root}/object/{name}/pose", take_in)
                self._followed[name] = (history, subscriber)
            return self._followed[name][0]

    def _subscribe(
        self,
        key: str,
        read: Callable[[str, bytes], Optional[T]],
        timeout: Optional[float],
        silence: Callable[[float], Exception],
    ) -> Subscription[T]:
        subscription = Subscription(read, timeout, silence)
        with self._lock:
            subscription._subscriber = self._open().declare_subscriber(f"{self._root}/{key}", _handler(subscription))
            self._dependents.add(subscription)
        return subscription

    def _reader(self, kind: str, field: str, record: type[T]) -> Callable[[str, bytes], Optional[T]]:
        """Reads messages whose name is that of their key; none for others."""

        def read(key: str, payload: bytes) -> Optional[T]:
            message = decode(payload, record)
            own = getattr(message, kind)
            return message if key == f"{self._root}/{kind}/{own}/{field}" else None

        return read

    def _pose_reader(self) -> Callable[[str, bytes], Optional[ObjectPose]]:
        """Reads poses by the fusion node that publishes now: none of older epochs."""
        read, epochs = self._reader("object", "pose", ObjectPose), EpochFilter()

        def read_current(key: str, payload: bytes) -> Optional[ObjectPose]:
            pose = read(key, payload)
            return pose if pose is not None and epochs.admits(pose.object, pose.epoch) else None

        return read_current

    def _check_object(self, name: str) -> None:
        """While no fusion node runs, this waits for one: it may still start."""
        _check_id("object", name)
        deadline = monotonic() + self._timeout
        while not any(config.tags for config in self._latest(f"config/object/{name}", ObjectConfig)):
            known = self.objects()
            if known:
                raise UnknownNameError("object", name, self.name, known)
            if monotonic() >= deadline:
                if any(node.kind == "fusion" for node in self.nodes()):
                    raise UnknownNameError("object", name, self.name, ())
                raise self._no_fusion()
            sleep(_PAUSE_S)

    def _no_fusion(self) -> SextantError:
        if not self.is_connected:
            return NoRouterError(self._access.endpoints, _RECONNECTING)
        return NoFusionError(self.name, self._other_sites())

    def _other_sites(self) -> list[str]:
        """Sites of the same router that have nodes. A protected router names none."""
        sites = set()
        for key in self._alive("sextant/*/*/alive/*/*"):
            _, version, site = key.split("/")[:3]
            sites.add(site if version == f"v{VERSION}" else f"{site} ({version})")
        return sorted(sites)

    def _latest(self, key: str, record: type[T]) -> list[T]:
        """Valid last values, one a key, in the order of the keys."""
        found = {}
        replies = self._open().get(
            f"{self._root}/{key}",
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=_ANSWER_S,
        )
        for reply in replies:
            sample = reply.ok
            # A time stamp is that of a storage, whose value may be of a process that has ended.
            if sample is None or sample.timestamp is not None or len(sample.payload) > MAX_BYTES:
                continue
            try:
                found[str(sample.key_expr)] = decode(bytes(sample.payload), record)
            except DecodeError:
                continue
        return [found[key] for key in sorted(found)]

    def _alive(self, key: str) -> list[str]:
        replies = self._open().liveliness().get(key, timeout=_ANSWER_S)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]

    def _open(self) -> Any:
        session = self._session
        if session is None:
            raise ClosedError(f"site {self.name!r} is closed")
        return session


def _handler(subscription: Subscription[Any]) -> Callable[[Any], None]:
    """Passes samples to a subscription without keeping it alive: an abandoned one ends."""
    reference = weakref.ref(subscription)

    def handle(sample: Any) -> None:
        target = reference()
        if target is not None:
            target._take_in(sample)

    return handle


def _transform(a: ObjectPose, b: ObjectPose) -> Transform:
    position, orientation, covariance = relative_pose(a, b)
    return Transform(
        a=a.object,
        b=b.object,
        t_ns=b.capture_ns,
        state=worse(a.state, b.state),
        position=vector(position),
        orientation=vector(orientation),
        covariance=matrix(covariance, 6),
    )


def _together(node: str, models: Sequence[Model]) -> Proposal:
    rigs = [encode(model) for model in models if isinstance(model, RigConfig)]
    objects = tuple(encode(model) for model in models if isinstance(model, ObjectConfig))
    if not models or len(rigs) > 1 or len(rigs) + len(objects) < len(models):
        raise TypeError("give one model, or one rig and objects together")
    return Proposal(node, 0, rigs[0] if rigs else None, objects, n_images=0, before_px=0.0, after_px=0.0)


def _check_id(what: str, name: str) -> None:
    if not isinstance(name, str) or not _ID.fullmatch(name):
        raise InvalidNameError(f"{name!r} is no {what} name: use 1 to 32 of a-z, 0-9, `_` and `-`")
