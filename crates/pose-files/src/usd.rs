//! USD as text (openusd.org, file format `usda` 1.0), for Blender, Houdini, Unreal, Isaac Sim and usdview.
//!
//! Metres, z up, as Sextant's world. Time codes count frames at the usual rate of the poses from the first pose on;
//! samples lie between frames where their capture times do. Object poses are `xformOp:translate` and `xformOp:orient`
//! as 64-bit floats. `GfSlerp` interpolates the latter.
//!
//! A `UsdGeomCamera` gives lengths in tenths of a unit and has a sensor. Ours is 36 mm wide; only ratios matter. The
//! principal point is an aperture offset, distortion is in `sextant:lens:` attributes that nothing else reads.

use crate::animation::{
    AnimatedLink, AnimatedObject, Animation, PlacedCamera, PlacedTag, to_gl_camera,
};
use sextant_geometry::{Pose, PoseParts, tag_corners_in_tag};
use std::collections::BTreeSet;
use std::io::{self, Write};

/// Width of a sensor, in tenths of a metre.
const SENSOR_WIDTH: f64 = 0.36;

/// Writes an animation as the text of a USD layer.
///
/// # Errors
/// Those of `out`.
pub fn write_usda(animation: &Animation, out: &mut impl Write) -> io::Result<()> {
    let mut layer = Layer {
        out,
        rate_hz: animation.rate_hz as f64,
        animation,
        depth: 0,
    };
    layer.metadata()?;
    layer.open("Xform", "Site", None)?;
    layer.open("Xform", "Cameras", None)?;
    let mut names = Names::default();
    for placed in &animation.cameras {
        layer.camera(placed, &names.unique(placed.camera.id.as_str()))?;
    }
    layer.close()?;
    layer.open("Xform", "Objects", None)?;
    let mut names = Names::default();
    for object in &animation.objects {
        layer.object(object, &names.unique(object.id.as_str()))?;
    }
    layer.close()?;
    layer.close()
}

/// A layer that is being written.
struct Layer<'a, W> {
    out: &'a mut W,
    rate_hz: f64,
    animation: &'a Animation,
    depth: usize,
}

impl<W: Write> Layer<'_, W> {
    fn metadata(&mut self) -> io::Result<()> {
        let (rate, end) = (
            self.animation.rate_hz,
            self.time_code(self.animation.end_ns),
        );
        let start_ns = self.animation.start_ns;
        write!(
            self.out,
            "#usda 1.0
(
    customLayerData = {{
        string generator = \"Sextant {}\"
        uint64 startTimeNs = {start_ns}
    }}
    defaultPrim = \"Site\"
    endTimeCode = {end}
    framesPerSecond = {rate}
    metersPerUnit = 1
    startTimeCode = 0
    timeCodesPerSecond = {rate}
    upAxis = \"Z\"
)

",
            env!("CARGO_PKG_VERSION")
        )
    }

    fn time_code(&self, t_ns: u64) -> f64 {
        t_ns.saturating_sub(self.animation.start_ns) as f64 * self.rate_hz / 1e9
    }

    fn line(&mut self, text: &str) -> io::Result<()> {
        writeln!(self.out, "{:width$}{text}", "", width = 4 * self.depth)
    }

    /// Begins a prim. The display name is what it is called in Sextant.
    fn open(&mut self, kind: &str, name: &str, display_name: Option<&str>) -> io::Result<()> {
        match display_name {
            Some(display_name) => {
                self.line(&format!("def {kind} \"{name}\" ("))?;
                self.line(&format!("    displayName = \"{display_name}\""))?;
                self.line(")")?;
            }
            None => self.line(&format!("def {kind} \"{name}\""))?,
        }
        self.line("{")?;
        self.depth += 1;
        Ok(())
    }

    fn close(&mut self) -> io::Result<()> {
        self.depth -= 1;
        self.line("}")
    }

    fn camera(&mut self, placed: &PlacedCamera, name: &str) -> io::Result<()> {
        let camera = &placed.camera;
        self.open("Camera", name, Some(camera.id.as_str()))?;
        let [width, height] = camera.resolution.map(f64::from);
        let lens = camera.lens.intrinsics();
        let focal = lens.fx / width * SENSOR_WIDTH;
        let centre = [
            (0.5 * (width - 1.0) - lens.cx) / lens.fx,
            (lens.cy - 0.5 * (height - 1.0)) / lens.fy,
        ];
        let model = camera.lens.model().to_string();
        let (fx, fy, cx, cy) = (lens.fx, lens.fy, lens.cx, lens.cy);
        let distortion = joined(camera.lens.distortion());
        let [columns, rows] = camera.resolution;
        for text in [
            "float2 clippingRange = (0.01, 1000)".to_owned(),
            format!("float focalLength = {focal}"),
            format!("float horizontalAperture = {SENSOR_WIDTH}"),
            format!("float horizontalApertureOffset = {}", centre[0] * focal),
            "token projection = \"perspective\"".to_owned(),
            format!("float verticalAperture = {}", height / lens.fy * focal),
            format!("float verticalApertureOffset = {}", centre[1] * focal),
            format!("custom double[] sextant:lens:distortion = [{distortion}]"),
            format!("custom double4 sextant:lens:intrinsics = ({fx}, {fy}, {cx}, {cy})"),
            format!("custom token sextant:lens:model = \"{model}\""),
            format!("custom int2 sextant:resolution = ({columns}, {rows})"),
        ] {
            self.line(&text)?;
        }
        self.place(&to_gl_camera(&placed.parent_from_camera))?;
        self.close()
    }

    fn object(&mut self, object: &AnimatedObject, name: &str) -> io::Result<()> {
        self.open("Xform", name, Some(object.id.as_str()))?;
        let changes = object.visibility(self.animation);
        if !changes.is_empty() {
            let changes = changes.into_iter().map(|(t_ns, is_visible)| {
                let token = if is_visible { "inherited" } else { "invisible" };
                (t_ns, format!("\"{token}\""))
            });
            self.samples("token visibility", changes)?;
        }
        self.motion(object.samples())?;
        let mut names = Names::default();
        for link in &object.links {
            self.link(link, &names.unique(link.id.as_str()))?;
        }
        self.tags(&object.tags, &mut names)?;
        for camera in &object.cameras {
            self.camera(camera, &names.unique(camera.camera.id.as_str()))?;
        }
        self.close()
    }

    fn link(&mut self, link: &AnimatedLink, name: &str) -> io::Result<()> {
        self.open("Xform", name, Some(link.id.as_str()))?;
        self.motion(link.samples.iter().copied())?;
        self.tags(&link.tags, &mut Names::default())?;
        self.close()
    }

    fn tags(&mut self, tags: &[PlacedTag], names: &mut Names) -> io::Result<()> {
        for placed in tags {
            let tag = &placed.tag.tag;
            let name = names.unique(&format!("{}_{}", tag.family, tag.id));
            self.open("Mesh", &name, Some(&tag.to_string()))?;
            let half = 0.5 * placed.tag.size_m;
            let corners = tag_corners_in_tag(placed.tag.size_m);
            let corners = corners.map(|p| format!("({}, {}, {})", p.x, p.y, p.z));
            for text in [
                "uniform bool doubleSided = 1".to_owned(),
                format!(
                    "float3[] extent = [({0}, {0}, 0), ({half}, {half}, 0)]",
                    -half
                ),
                "int[] faceVertexCounts = [4]".to_owned(),
                // Counter-clockwise for who looks at the face.
                "int[] faceVertexIndices = [0, 3, 2, 1]".to_owned(),
                format!("point3f[] points = [{}]", corners.join(", ")),
                "color3f[] primvars:displayColor = [(0.02, 0.02, 0.02)]".to_owned(),
                "uniform token subdivisionScheme = \"none\"".to_owned(),
            ] {
                self.line(&text)?;
            }
            self.place(&placed.parent_from_tag)?;
            self.close()?;
        }
        Ok(())
    }

    /// A pose that does not change.
    fn place(&mut self, pose: &Pose) -> io::Result<()> {
        let (position, orientation) = texts(pose);
        self.line(&format!("quatd xformOp:orient = {orientation}"))?;
        self.line(&format!("double3 xformOp:translate = {position}"))?;
        self.order()
    }

    fn motion(&mut self, samples: impl Iterator<Item = (u64, Pose)> + Clone) -> io::Result<()> {
        let orientations = samples.clone().map(|(t_ns, pose)| (t_ns, texts(&pose).1));
        self.samples("quatd xformOp:orient", orientations)?;
        let positions = samples.map(|(t_ns, pose)| (t_ns, texts(&pose).0));
        self.samples("double3 xformOp:translate", positions)?;
        self.order()
    }

    fn order(&mut self) -> io::Result<()> {
        self.line("uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]")
    }

    fn samples(
        &mut self,
        attribute: &str,
        samples: impl Iterator<Item = (u64, String)>,
    ) -> io::Result<()> {
        self.line(&format!("{attribute}.timeSamples = {{"))?;
        for (t_ns, value) in samples {
            let time_code = self.time_code(t_ns);
            self.line(&format!("    {time_code}: {value},"))?;
        }
        self.line("}")
    }
}

/// Position and orientation, w first.
fn texts(pose: &Pose) -> (String, String) {
    let PoseParts {
        position: [px, py, pz],
        orientation: [x, y, z, w],
    } = PoseParts::from(pose);
    (
        format!("({px}, {py}, {pz})"),
        format!("({w}, {x}, {y}, {z})"),
    )
}

fn joined(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
    numbers.join(", ")
}

/// Names of the children of a prim: letters, digits and underscores, no two alike.
#[derive(Default)]
struct Names(BTreeSet<String>);

impl Names {
    fn unique(&mut self, id: &str) -> String {
        let mut name = id.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        if name.starts_with(|c: char| c.is_ascii_digit()) {
            name.insert(0, '_');
        }
        while !self.0.insert(name.clone()) {
            name.push('_');
        }
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::tests::{animation, pose};
    use sextant_site_report::State;

    fn usda() -> String {
        let states = [
            (0, State::Tracking),
            (20, State::Lost),
            (40, State::Tracking),
        ];
        let poses = states.map(|(t_ms, state)| pose("cube", t_ms, state, 0.0));
        let mut text = Vec::new();
        write_usda(&animation(&poses), &mut text).unwrap();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn a_layer_has_cameras_objects_and_tags() {
        let text = usda();
        for line in [
            "    metersPerUnit = 1",
            "    upAxis = \"Z\"",
            "    timeCodesPerSecond = 50",
            "        uint64 startTimeNs = 1800000000000000000",
            "        def Camera \"north_1\" (",
            "            displayName = \"north-1\"",
            "        def Xform \"cube\" (",
            "            def Mesh \"tag36h11_3\" (",
            "                displayName = \"tag36h11:3\"",
            "                    0: \"inherited\",",
        ] {
            let line = line.trim_start();
            assert!(
                text.lines().any(|is| is.trim_start() == line),
                "{line}: {text}"
            );
        }
        assert!(!text.contains("NaN") && !text.contains("inf"));
        assert_eq!(text.matches('{').count(), text.matches('}').count());
    }

    #[test]
    fn an_object_is_invisible_while_it_is_lost() {
        let text = usda();
        let (_, rest) = text.split_once("visibility.timeSamples = {").unwrap();
        let samples = rest.split_once('}').unwrap().0.split_whitespace();
        let samples: Vec<&str> = samples.collect();
        assert_eq!(
            samples,
            [
                "0:",
                "\"inherited\",",
                "1:",
                "\"invisible\",",
                "2:",
                "\"inherited\","
            ]
        );
    }

    #[test]
    fn names_are_identifiers_and_differ() {
        let mut names = Names::default();
        let named = ["a-b", "a_b", "3d", "a.b"].map(|id| names.unique(id));
        assert_eq!(named, ["a_b", "a_b_", "_3d", "a_b__"]);
    }
}
