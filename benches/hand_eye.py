"""Hand-eye calibration by OpenCV on the recording of sextant/tests/board-on-robot: held-out errors by method, as in
BENCHMARKS.md ("Robots").

    pip install opencv-python-headless==4.10.0.84 && python benches/hand_eye.py
"""

import json
import tomllib
from pathlib import Path

import cv2
import numpy as np
from numpy.linalg import inv

DATA = Path(__file__).parent.parent / "sextant/tests/board-on-robot"
FOLDS = 10


def motion(rotation, position):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, np.ravel(position)
    return pose


def of_quaternion(x, y, z, w):
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def corners_on_board():
    corners = {}
    for tag in tomllib.loads((DATA / "board.toml").read_text())["tag"]:
        half, place = tag["size"] / 2, tag["object_from_tag"]
        pose = motion(of_quaternion(*place["orientation"]), place["position"])
        square = half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
        corners[tag["id"]] = square @ pose[:3, :3].T + pose[:3, 3]
    return corners


def hand_eye(method):
    def solve(hands, boards):
        bases = [inv(hand) for hand in hands]
        base_from_camera = motion(
            *cv2.calibrateHandEye(*split(bases), *split(boards), method=method)
        )
        places = [inv(hand) @ base_from_camera @ board for hand, board in zip(hands, boards)]
        u, _, v = np.linalg.svd(sum(place[:3, :3] for place in places))
        rotation = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
        return base_from_camera, motion(rotation, np.mean([p[:3, 3] for p in places], 0))

    return solve


def robot_world(method):
    def solve(hands, boards):
        # camera_from_board board_from_hand = camera_from_base base_from_hand
        found = cv2.calibrateRobotWorldHandEye(*split(boards), *split(hands), method=method)
        return inv(motion(*found[2:])), inv(motion(*found[:2]))

    return solve


def split(poses):
    return [pose[:3, :3] for pose in poses], [pose[:3, 3] for pose in poses]


METHODS = {
    "Tsai": hand_eye(cv2.CALIB_HAND_EYE_TSAI),
    "Park": hand_eye(cv2.CALIB_HAND_EYE_PARK),
    "Horaud": hand_eye(cv2.CALIB_HAND_EYE_HORAUD),
    "Andreff": hand_eye(cv2.CALIB_HAND_EYE_ANDREFF),
    "Daniilidis": hand_eye(cv2.CALIB_HAND_EYE_DANIILIDIS),
    "Shah": robot_world(cv2.CALIB_ROBOT_WORLD_HAND_EYE_SHAH),
    "Li": robot_world(cv2.CALIB_ROBOT_WORLD_HAND_EYE_LI),
}


def main():
    corners = corners_on_board()
    rows = (DATA / "robot.csv").read_text().splitlines()[1:]
    rows = [[float(cell) for cell in row.split(",")] for row in rows]
    robot = {int(row[0]): motion(of_quaternion(*row[4:8]), row[1:4]) for row in rows}
    lines = (DATA / "mako/detections.jsonl").read_text().splitlines()
    images = sorted(map(json.loads, lines), key=lambda image: image["t_ns"])
    hands = [robot[image["t_ns"]] for image in images]
    for file in ["rig.toml", "lens.toml"]:
        lens = tomllib.loads((DATA / file).read_text())["camera"][0]["lens"]
        matrix = np.array([[lens["fx"], 0, lens["cx"]], [0, lens["fy"], lens["cy"]], [0, 0, 1]])
        distortion = np.array(lens["distortion"])
        seen, boards = [], []
        for image in images:
            tags = [tag for tag in image["detections"] if tag["id"] in corners]
            points = np.concatenate([corners[tag["id"]] for tag in tags])
            pixels = np.concatenate([np.array(tag["corners"], float) for tag in tags])
            _, turn, shift = cv2.solvePnP(points, pixels, matrix, distortion)
            turn, shift = cv2.solvePnPRefineLM(points, pixels, matrix, distortion, turn, shift)
            seen.append((points, pixels))
            boards.append(motion(cv2.Rodrigues(turn)[0], shift))
        n = len(images)
        for name, solve in METHODS.items():
            errors = []
            for fold in range(FOLDS):
                out = range(fold * n // FOLDS, (fold + 1) * n // FOLDS)
                rest = [i for i in range(n) if i not in out]
                base, hand = solve([hands[i] for i in rest], [boards[i] for i in rest])
                for i in out:
                    predicted = inv(base) @ hands[i] @ hand
                    off = inv(predicted) @ boards[i]
                    angle = np.degrees(np.linalg.norm(cv2.Rodrigues(off[:3, :3])[0]))
                    turn, shift = cv2.Rodrigues(predicted[:3, :3])[0], predicted[:3, 3]
                    pixels, _ = cv2.projectPoints(seen[i][0], turn, shift, matrix, distortion)
                    squares = np.sum((pixels[:, 0] - seen[i][1]) ** 2, 1)
                    errors.append((1e3 * np.linalg.norm(off[:3, 3]), angle, squares.mean() ** 0.5))
            mm, degrees, px = np.sqrt(np.mean(np.square(errors), 0))
            print(f"{file:10} {name:10} {mm:6.2f} mm {degrees:5.2f} degrees {px:5.1f} px")


main()
