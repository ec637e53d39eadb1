//! The state as one line of JSON.

use crate::top::board::Board;
use crate::top::rows::{CameraRow, ObjectRow};
use crate::top::table::{latency_ms, sigma_of};
use crate::words;
use serde_json::{Value, json};
use sextant_site_mirror::Liveliness;

/// The state at `now_ns`; unknown values are null.
pub fn line(board: &Board, now_ns: u64) -> String {
    let nodes = board.nodes(now_ns).map(|(kind, id, node)| {
        json!({
            "kind": kind.as_str(), "id": id, "up": node.liveliness != Liveliness::Gone,
            "age_s": node.heard_ns.map(|heard_ns| age_ms(heard_ns, now_ns) / 1e3),
        })
    });
    let cameras = board.cameras(now_ns).into_iter();
    let cameras = cameras.map(|row| camera(&row, now_ns));
    let objects = board.objects(now_ns).into_iter();
    let objects = objects.map(|row| object(&row, now_ns));
    let faults = board.faults(now_ns).into_iter();
    let finding = |(from, words): (String, String)| json!({"from": from, "words": words});
    let faults: Vec<_> = faults.map(finding).collect();
    let information = board.information(now_ns).into_iter();
    let information: Vec<_> = information.map(finding).collect();
    json!({
        "site": board.keys.site(), "t_ns": now_ns, "connected": board.disconnected_s.is_none(),
        "nodes": nodes.collect::<Vec<_>>(), "cameras": cameras.collect::<Vec<_>>(),
        "objects": objects.collect::<Vec<_>>(), "faults": faults, "information": information,
    })
    .to_string()
}

fn age_ms(then_ns: u64, now_ns: u64) -> f64 {
    now_ns.saturating_sub(then_ns) as f64 / 1e6
}

fn camera(row: &CameraRow<'_>, now_ns: u64) -> Value {
    let (status, intake, clock) = (row.status, row.intake, row.clock);
    json!({
        "id": row.id,
        "rate_hz": status.map(|s| s.rate_hz).or(intake.map(|i| i.rate_hz)),
        "detect_ms": status.map(|s| s.detect_ms),
        "captured": status.map(|s| s.captured),
        "dropped": status.map(|s| s.dropped),
        "clock": {
            "source": status.map(|s| s.clock.source.name()),
            "error_ms": status.map(|s| s.clock.error_ns as f64 / 1e6),
            "offset_ms": clock.map(|c| c.offset_s * 1e3),
            "sigma_ms": clock.map(|c| c.sigma_s * 1e3),
            "drift_ppm": clock.and_then(|c| c.drift).map(|drift| drift * 1e6),
        },
        "image_age_ms": row.last_capture_ns.map(|capture_ns| age_ms(capture_ns, now_ns)),
        "received": intake.map(|i| i.received),
        "refused": intake.map(|i| i.rejected),
        "late": intake.map(|i| i.late),
        "gated": intake.map(|i| i.gated),
        "unknown_tags": intake.map(|i| i.unknown_tags),
        "gone_s": row.gone_ns.map(|gone_ns| age_ms(gone_ns, now_ns) / 1e3),
    })
}

fn object(row: &ObjectRow<'_>, now_ns: u64) -> Value {
    let pose = row.pose;
    json!({
        "id": row.id,
        "state": words::state(row.state),
        "rate_hz": row.rate_hz,
        "position": pose.map(|p| p.position),
        "orientation": pose.map(|p| p.orientation),
        "sigma_mm": pose.map(|p| sigma_of(&p.covariance, 0) * 1e3),
        "sigma_deg": pose.map(|p| sigma_of(&p.covariance, 3).to_degrees()),
        "cameras": pose.map(|p| p.cameras),
        "tags": pose.map(|p| p.tags),
        "latency_ms": pose.map(|p| latency_ms(p.capture_ns, p.published_ns)),
        "pose_age_ms": pose.map(|p| age_ms(p.capture_ns, now_ns)),
        "gone_s": row.gone_ns.map(|gone_ns| age_ms(gone_ns, now_ns) / 1e3),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::board::tests::{NOW_NS, board};

    #[test]
    fn everything_is_there_and_unknown_things_are_null() {
        let line: Value = serde_json::from_str(&line(&board(), NOW_NS)).unwrap();
        let (camera, objects) = (&line["cameras"][0], &line["objects"]);
        assert_eq!(line["connected"], true);
        assert_eq!(camera["id"], "north");
        assert_eq!(camera["clock"]["source"], "ntp");
        assert!((camera["clock"]["offset_ms"].as_f64().unwrap() + 12.5).abs() < 1e-9);
        assert_eq!(camera["refused"]["damaged"], 2);
        assert_eq!(camera["image_age_ms"], 40.0);
        assert_eq!(objects[0]["id"], "ball");
        assert_eq!(objects[0]["position"], Value::Null);
        assert_eq!(objects[1]["state"], "tracking");
        assert_eq!(objects[1]["latency_ms"], 20.5);
        assert_eq!(line["faults"][0]["from"], "fusion");
    }
}
