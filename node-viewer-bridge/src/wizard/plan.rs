//! From a person's request to a procedure: names, sizes and files checked, each complaint at the field that it is
//! about.

use super::command::{
    BoardRequest, GridRequest, ObjectRequest, OriginRequest, Others, Start, TagRequest,
};
use crate::refusal::Refusal;
use sextant_calibrator::lens::Selection;
use sextant_calibrator::procedure::{LensPlan, Plan};
use sextant_calibrator::{Gauge, GridError, LearnPlan, Origin, PrintedGrid, RigPlan};
use sextant_site_files::parse_object;
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{CameraId, ObjectId, ObjectModel, Rig, TagId};
use sextant_tag_families::Family;
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// Sizes of tags, metres.
const SIZES_M: std::ops::RangeInclusive<f64> = 0.001..=100.0;

/// What a request asks for, on a site whose rig is this one.
pub(super) fn plan(request: &Start, site: &SiteMirror, rig: &Rig) -> Result<Plan, Refusal> {
    match request {
        Start::Lens {
            camera,
            board,
            model,
        } => lens(site, camera, board, model.as_deref()).map(Plan::Lens),
        Start::Rig { object, origin } => {
            if rig.cameras().len() < 2 {
                return Err(Refusal::wrong(
                    "object",
                    "the site's rig has fewer than two cameras: find their lenses first",
                ));
            }
            Ok(Plan::Rig(RigPlan {
                object: carried(site, object)?,
                origin: self::origin(origin, rig)?,
            }))
        }
        Start::Learn { .. } => learn(request, site, rig).map(Plan::Learn),
    }
}

/// What the wizard is about, in a word: a camera, or an object.
pub(super) fn subject(plan: &Plan) -> String {
    match plan {
        Plan::Lens(plan) => plan.camera.to_string(),
        Plan::Rig(plan) => plan.object.id().to_string(),
        Plan::Learn(plan) => plan.object.to_string(),
        Plan::Discover(plan) => plan.object.to_string(),
    }
}

fn lens(
    site: &SiteMirror,
    camera: &str,
    board: &BoardRequest,
    model: Option<&str>,
) -> Result<LensPlan, Refusal> {
    let camera: CameraId = read("camera", camera)?;
    let resolution = site.resolution(&camera).ok_or_else(|| {
        Refusal::wrong(
            "camera",
            format!("camera {camera} has sent no image yet; is its node running?"),
        )
    })?;
    Ok(LensPlan {
        board: self::board(board)?,
        model: model.map(|model| read("model", model)).transpose()?,
        selection: Selection::New,
        camera,
        resolution,
    })
}

fn board(request: &BoardRequest) -> Result<ObjectModel, Refusal> {
    match request {
        BoardRequest::File(text) => file("board", text),
        BoardRequest::Grid(grid) => printed(grid),
    }
}

fn printed(request: &GridRequest) -> Result<ObjectModel, Refusal> {
    let grid = PrintedGrid {
        columns: request.columns,
        rows: request.rows,
        size_m: size(request.size_m)?,
        family: read("family", &request.family)?,
        first: request.first,
    };
    grid.object("board").map_err(|error| {
        let field = match error {
            GridError::Empty => "columns",
            GridError::TooManyTags { .. } => "first",
            GridError::Object(_) | GridError::Id(_) => "size_m",
        };
        Refusal::wrong(field, error)
    })
}

fn carried(site: &SiteMirror, request: &ObjectRequest) -> Result<ObjectModel, Refusal> {
    match request {
        ObjectRequest::File(text) => file("object", text),
        ObjectRequest::Known(id) => {
            let id: ObjectId = read("object", id)?;
            let object = site.object_model(&id);
            object.ok_or_else(|| Refusal::wrong("object", format!("the site has no object {id}")))
        }
    }
}

fn origin(request: &OriginRequest, rig: &Rig) -> Result<Origin, Refusal> {
    match request {
        OriginRequest::AsItIs => {
            let placed = rig.cameras().iter().find(|c| c.world_from_camera.is_some());
            Ok(placed.map_or(Origin::FirstCamera, |c| Origin::Camera(c.id.clone())))
        }
        OriginRequest::Camera(id) => Ok(Origin::Camera(camera_of(rig, "origin", id)?)),
        OriginRequest::Tag { family, id, size_m } => {
            let tag = tag_of(read("family", family)?, *id)?;
            Ok(Origin::Tag(tag, size(*size_m)?))
        }
    }
}

fn learn(request: &Start, site: &SiteMirror, rig: &Rig) -> Result<LearnPlan, Refusal> {
    let Start::Learn {
        id,
        family,
        tags,
        cameras,
        origin,
        others,
    } = request
    else {
        return Err(Refusal::not_now("no object is to be learned"));
    };
    let object: ObjectId = read("id", id)?;
    let family: Family = read("family", family)?;
    let cameras = cameras.iter().map(|id| camera_of(rig, "cameras", id));
    let gauge = match origin {
        Some(id) => Gauge::Tag(tag_of(family, *id)?),
        None => Gauge::Centroid,
    };
    if rig.cameras().is_empty() {
        return Err(Refusal::wrong(
            "cameras",
            "no camera's lens is known yet: find it with the lens wizard first",
        ));
    }
    let from = (*others == Others::Keep).then(|| site.object_model(&object));
    Ok(LearnPlan {
        tags: wanted(family, tags)?,
        cameras: cameras.collect::<Result<_, _>>()?,
        gauge,
        from: from.flatten(),
        object,
    })
}

fn wanted(family: Family, requests: &[TagRequest]) -> Result<Vec<(TagId, f64)>, Refusal> {
    if requests.is_empty() {
        return Err(Refusal::wrong(
            "tags",
            "name the object's tags, or show it to a camera and choose those that are seen",
        ));
    }
    let mut tags = Vec::with_capacity(requests.len());
    for request in requests {
        let tag = tag_of(family, request.id)?;
        if tags.iter().any(|(other, _)| *other == tag) {
            return Err(Refusal::wrong("tags", format!("{tag} is named twice")));
        }
        tags.push((tag, size(request.size_m)?));
    }
    Ok(tags)
}

fn tag_of(family: Family, id: u32) -> Result<TagId, Refusal> {
    let n_codes = family.data().codes.len();
    if (id as usize) < n_codes {
        return Ok(TagId { family, id });
    }
    Err(Refusal::wrong(
        "tags",
        format!("{family} has the tags 0 to {}, not {id}", n_codes - 1),
    ))
}

fn camera_of(rig: &Rig, field: &'static str, id: &str) -> Result<CameraId, Refusal> {
    let id: CameraId = read(field, id)?;
    let known = rig.camera(&id).is_some();
    known
        .then(|| id.clone())
        .ok_or_else(|| Refusal::wrong(field, format!("the site's rig has no camera {id}")))
}

fn size(size_m: f64) -> Result<f64, Refusal> {
    SIZES_M
        .contains(&size_m)
        .then_some(size_m)
        .ok_or_else(|| Refusal::wrong("size_m", "the edge of a black square is 1 mm to 100 m long"))
}

fn file(field: &'static str, text: &str) -> Result<ObjectModel, Refusal> {
    parse_object(Path::new("the file"), text).map_err(|error| Refusal::wrong(field, error))
}

fn read<T: FromStr>(field: &'static str, text: &str) -> Result<T, Refusal>
where
    T::Err: Display,
{
    text.trim()
        .parse()
        .map_err(|error| Refusal::wrong(field, error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wizard::samples::{mirror, rig};

    fn refused(text: &str) -> (Option<&'static str>, String) {
        let request: Start = serde_json::from_str(text).unwrap();
        let refusal = plan(&request, &mirror(), &rig()).unwrap_err();
        (refusal.field, refusal.cause)
    }

    #[test]
    fn each_complaint_is_at_its_field() {
        let cases = [
            (
                r#"{"wizard":"lens","camera":"x y","board":{"file":""}}"#,
                "camera",
            ),
            (
                r#"{"wizard":"lens","camera":"nobody","board":{"file":""}}"#,
                "camera",
            ),
            (
                r#"{"wizard":"lens","camera":"a","board":{"file":"id = 3"}}"#,
                "board",
            ),
            (
                r#"{"wizard":"lens","camera":"a","board":{"grid":{"columns":0,"rows":6,"size_m":0.03}}}"#,
                "columns",
            ),
            (
                r#"{"wizard":"lens","camera":"a","board":{"grid":{"columns":5,"rows":6,"size_m":0.0003}}}"#,
                "size_m",
            ),
            (
                r#"{"wizard":"lens","camera":"a","board":{"grid":{"columns":5,"rows":6,"size_m":28000.0}}}"#,
                "size_m",
            ),
            (
                r#"{"wizard":"lens","camera":"a","board":{"grid":{"columns":50,"rows":60,"size_m":0.03}}}"#,
                "first",
            ),
            (
                r#"{"wizard":"lens","camera":"a","model":"fish","board":{"grid":{"columns":5,"rows":6,"size_m":0.03}}}"#,
                "model",
            ),
            (
                r#"{"wizard":"rig","object":{"known":"ball"},"origin":"as_it_is"}"#,
                "object",
            ),
            (
                r#"{"wizard":"rig","object":{"known":"cube"},"origin":{"camera":"z"}}"#,
                "origin",
            ),
            (
                r#"{"wizard":"learn","id":"Cube","tags":[{"id":1,"size_m":0.04}]}"#,
                "id",
            ),
            (r#"{"wizard":"learn","id":"cube","tags":[]}"#, "tags"),
            (
                r#"{"wizard":"learn","id":"cube","tags":[{"id":587,"size_m":0.04}]}"#,
                "tags",
            ),
            (
                r#"{"wizard":"learn","id":"cube","tags":[{"id":1,"size_m":0}]}"#,
                "size_m",
            ),
            (
                r#"{"wizard":"learn","id":"cube","family":"qr","tags":[{"id":1,"size_m":0.04}]}"#,
                "family",
            ),
            (
                r#"{"wizard":"learn","id":"cube","tags":[{"id":1,"size_m":0.04},{"id":1,"size_m":0.04}]}"#,
                "tags",
            ),
        ];
        for (request, field) in cases {
            let (at, cause) = refused(request);
            assert_eq!(at, Some(field), "{request}: {cause}");
            assert!(cause.len() > 10, "{request}: {cause}");
        }
    }

    #[test]
    fn the_world_stays_where_the_first_placed_camera_is() {
        let found = origin(&OriginRequest::AsItIs, &rig()).unwrap();
        assert_eq!(found, Origin::Camera("b".parse().unwrap()));
    }

    #[test]
    fn other_tags_of_a_known_object_stay_on_demand() {
        let learn = |others: &str| {
            let text = format!(
                r#"{{"wizard":"learn","id":"cube","tags":[{{"id":9,"size_m":0.04}}],"others":"{others}"}}"#
            );
            match plan(&serde_json::from_str(&text).unwrap(), &mirror(), &rig()) {
                Ok(Plan::Learn(plan)) => plan.from.is_some(),
                other => panic!("{other:?}"),
            }
        };
        assert!(learn("keep") && !learn("leave"));
    }
}
