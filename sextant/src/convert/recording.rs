//! Recordings in EuRoC folders to MCAP files and back: images bit for bit, detections, rig and objects.

use crate::model_files::{read_object, read_rig};
use crate::output::{Format, print_line};
use crate::simulate::make_empty;
use crate::words;
use anyhow::{Context, bail, ensure};
use serde_json::json;
use sextant_process::{Exit, WithExit};
use sextant_proto::{
    ClockQuality, ClockSource, Keys, ObjectConfig, Observations, RigConfig, SiteId, TagObservation,
    Timing, encode, limits,
};
use sextant_recordings::compressed_image::{self as image, RecordedImage};
use sextant_recordings::mcap::reader::{Ending, McapReader};
use sextant_recordings::mcap::site_recording::{Model, SiteRecording};
use sextant_recordings::mcap::writer::McapWriter;
use sextant_recordings::mcap::{RecordingInfo, is_mcap_file};
use sextant_recordings::{
    Dataset, DetectedTag, DetectionsLine, Frame, Row, grey_png, is_grey_png, read_picture,
};
use sextant_site_files::{write_object, write_rig};
use sextant_site_model::{CameraId, ObjectModel, Rig};
use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Site of a recording that comes from a folder.
const SITE: &str = "recording";

/// A conversion of a recording.
pub struct RecordingConversion<'a> {
    /// What is read.
    pub from: &'a Path,
    /// What is written.
    pub to: &'a Path,
    /// Rig file to put into an MCAP file.
    pub rig: Option<&'a Path>,
    /// Object files to put into an MCAP file.
    pub objects: &'a [PathBuf],
}

/// Counts of what was converted.
#[derive(Debug, Default)]
pub struct Counts {
    images: usize,
    detections: usize,
    /// Images of a camera with a capture time that an earlier one has.
    repeated: usize,
    /// Width and height of the images of each camera of an MCAP file, px, as its first detections state them.
    pub resolutions: BTreeMap<CameraId, [u32; 2]>,
}

impl Counts {
    /// Whether nothing was converted.
    pub fn is_empty(&self) -> bool {
        self.images + self.detections == 0
    }
}

/// Whether a path is one of a recording.
pub fn is_recording(path: &Path) -> bool {
    path.is_dir()
        || is_mcap_file(path)
        || path
            .extension()
            .is_some_and(|extension| extension == "mcap")
}

impl RecordingConversion<'_> {
    /// Converts.
    ///
    /// # Errors
    /// [`Exit::Input`] for a recording that cannot be used and a place that is taken.
    pub fn run(&self, format: Format) -> anyhow::Result<()> {
        let counts = if self.from.is_dir() {
            self.to_file()?
        } else {
            self.to_folder()?
        };
        if counts.repeated > 0 {
            eprintln!(
                "{} images with the capture time of an earlier one were left out",
                counts.repeated
            );
        }
        let to = self.to.display();
        let (images, detections) = (counts.images, counts.detections);
        let line = match format {
            Format::Json => {
                json!({ "to": to.to_string(), "images": images, "detections": detections })
                    .to_string()
            }
            Format::Text => format!(
                "{to}: {}, detections of {}",
                words::count(images, "image"),
                words::count(detections, "image")
            ),
        };
        Ok(print_line(&line)?)
    }

    /// Writes an MCAP file.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn to_file(&self) -> anyhow::Result<Counts> {
        let dataset = Dataset::open(self.from).exit_with(Exit::Input)?;
        let rig = self.rig.map(read_rig).transpose().exit_with(Exit::Input)?;
        let objects = self.objects.iter().map(|file| read_object(file));
        let objects: Vec<ObjectModel> = objects.collect::<Result<_, _>>().exit_with(Exit::Input)?;
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(self.to);
        let file = file
            .with_context(|| format!("{}: choose a new name", self.to.display()))
            .exit_with(Exit::Input)?;
        let info = RecordingInfo {
            site: SITE.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let mut sink = FileSink {
            keys: Keys::for_site(SiteId::new(SITE)?),
            writer: McapWriter::begin(BufWriter::new(file), self.to, &info)?,
            rig: rig.as_ref(),
            sequences: BTreeMap::new(),
            counts: Counts::default(),
        };
        let rows = dataset.rows_by_arrival();
        let first_ns = rows.first().map_or(0, |row| row.arrival_ns);
        sink.write_models(&objects, first_ns)?;
        for row in rows {
            sink.write(row)?;
        }
        sink.writer.finish()?;
        Ok(sink.counts)
    }

    /// Writes a folder.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn to_folder(&self) -> anyhow::Result<Counts> {
        // First, so that an invalid file leaves no folder behind.
        let recording = SiteRecording::read(self.from).exit_with(Exit::Input)?;
        if recording.ending != Ending::Closed {
            eprintln!("{}: {}", self.from.display(), recording.ending);
        }
        make_empty(self.to).exit_with(Exit::Input)?;
        let mut counts = Counts::default();
        write_models(self.to, &recording)?;
        let arrivals = write_detections(self.to, &recording, &mut counts)?;
        write_images(self.from, self.to, &arrivals, &mut counts)?;
        Ok(counts)
    }
}

/// An MCAP file that is being made from a folder.
struct FileSink<'a, W: std::io::Write> {
    keys: Keys,
    writer: McapWriter<W>,
    rig: Option<&'a Rig>,
    /// Numbers of the next observations.
    sequences: BTreeMap<CameraId, u64>,
    counts: Counts,
}

impl<W: std::io::Write> FileSink<'_, W> {
    fn write_models(&mut self, objects: &[ObjectModel], first_ns: u64) -> anyhow::Result<()> {
        if let Some(rig) = self.rig {
            let payload = encode(&RigConfig::from(rig))?;
            self.writer
                .write_payload(&self.keys.config_rig(), &payload, first_ns)?;
        }
        for object in objects {
            let payload = encode(&ObjectConfig::from(object))?;
            let key = self.keys.config_object(object.id());
            self.writer.write_payload(&key, &payload, first_ns)?;
        }
        Ok(())
    }

    fn write(&mut self, row: &Row) -> anyhow::Result<()> {
        match &row.frame {
            Frame::Picture(path) => {
                let png = png_of(path)?;
                let image = RecordedImage {
                    camera: row.camera.clone(),
                    capture_ns: row.capture_ns,
                    png,
                };
                self.writer.write_image(&image, row.arrival_ns)?;
                self.counts.images += 1;
            }
            Frame::Detections(tags) => {
                let message = self.observations(row, tags).exit_with(Exit::Input)?;
                let key = self.keys.observations(&row.camera);
                let payload = encode(&message)
                    .with_context(|| format!("camera {}, t_ns {}", row.camera, row.capture_ns))
                    .exit_with(Exit::Input)?;
                self.writer.write_payload(&key, &payload, row.arrival_ns)?;
                self.counts.detections += 1;
            }
        }
        Ok(())
    }

    fn observations(&mut self, row: &Row, tags: &[DetectedTag]) -> anyhow::Result<Observations> {
        let camera = self.rig.and_then(|rig| rig.camera(&row.camera));
        let resolution = camera.map(|camera| camera.resolution);
        let resolution = resolution.with_context(|| {
            format!(
                "camera {}: detections do not say how large images are; name a rig with this camera with --rig",
                row.camera
            )
        })?;
        ensure!(
            tags.len() <= limits::MAX_TAGS,
            "camera {}, t_ns {}: {} tags are more than a recording takes of one image",
            row.camera,
            row.capture_ns,
            tags.len()
        );
        let sequence = self.sequences.entry(row.camera.clone()).or_default();
        *sequence += 1;
        Ok(Observations {
            camera: row.camera.clone(),
            sequence: *sequence,
            capture_ns: row.capture_ns,
            exposure_ns: 0,
            clock: ClockQuality {
                source: ClockSource::Recorded,
                error_ns: 0,
            },
            resolution: resolution.map(|pixels| u16::try_from(pixels).unwrap_or(u16::MAX)),
            timing: Timing::default(),
            tags: tags.iter().map(tag_observation).collect(),
        })
    }
}

/// A covariance of zeros is an unknown one.
fn tag_observation(tag: &DetectedTag) -> TagObservation {
    let variance = tag.sigma_px.map_or(0.0, |sigma| sigma * sigma);
    TagObservation {
        family: tag.family,
        id: tag.id,
        hamming: 0,
        margin: 0.0,
        corners: tag.corners,
        corner_covariance: tag
            .corner_covariance
            .unwrap_or([[variance, 0.0, variance]; 4]),
        corner_cross_covariance: tag.corner_cross_covariance.unwrap_or_default(),
        poses: Vec::new(),
    }
}

fn detected_tag(tag: &TagObservation) -> DetectedTag {
    let is_known = tag
        .corner_covariance
        .iter()
        .all(|[xx, _, yy]| *xx > 0.0 && *yy > 0.0);
    let is_correlated = tag
        .corner_cross_covariance
        .iter()
        .flatten()
        .any(|v| *v != 0.0);
    DetectedTag {
        family: tag.family,
        id: tag.id,
        corners: tag.corners,
        sigma_px: None,
        corner_covariance: is_known.then_some(tag.corner_covariance),
        corner_cross_covariance: (is_known && is_correlated).then_some(tag.corner_cross_covariance),
    }
}

/// `rig.toml` and `<object>.toml`, as they were at the beginning.
fn write_models(folder: &Path, recording: &SiteRecording) -> anyhow::Result<()> {
    let mut written = std::collections::BTreeSet::new();
    for timed in &recording.models {
        match &timed.item.model {
            Model::Rig(config) if written.insert("rig".to_owned()) => {
                write_rig(&folder.join("rig.toml"), &Rig::try_from(config)?)?;
            }
            Model::Object(config)
                if !config.is_removal() && written.insert(format!("object {}", config.id)) =>
            {
                let model = ObjectModel::try_from(config)?;
                write_object(&folder.join(format!("{}.toml", config.id)), &model)?;
            }
            Model::Rig(_) | Model::Object(_) => {}
        }
    }
    Ok(())
}

/// Arrival by camera and capture time.
type Arrivals = BTreeMap<CameraId, BTreeMap<u64, u64>>;

fn write_detections(
    folder: &Path,
    recording: &SiteRecording,
    counts: &mut Counts,
) -> anyhow::Result<Arrivals> {
    let mut cameras: BTreeMap<&CameraId, BTreeMap<u64, String>> = BTreeMap::new();
    let mut arrivals = Arrivals::new();
    for timed in &recording.observations {
        let image = &timed.item;
        let line = DetectionsLine {
            t_ns: image.capture_ns,
            arrival_ns: Some(timed.arrival_ns),
            detections: image.tags.iter().map(detected_tag).collect(),
        };
        let lines = cameras.entry(&image.camera).or_default();
        if lines.contains_key(&image.capture_ns) {
            counts.repeated += 1;
            continue;
        }
        lines.insert(image.capture_ns, serde_json::to_string(&line)? + "\n");
        let arrivals = arrivals.entry(image.camera.clone()).or_default();
        arrivals.insert(image.capture_ns, timed.arrival_ns);
        let resolution = image.resolution.map(u32::from);
        let camera = image.camera.clone();
        counts.resolutions.entry(camera).or_insert(resolution);
        counts.detections += 1;
    }
    for (camera, lines) in cameras {
        let file = camera_folder(folder, camera)?.join("detections.jsonl");
        let text: String = lines.into_values().collect();
        fs::write(&file, text).with_context(|| file.display().to_string())?;
    }
    Ok(arrivals)
}

fn write_images(
    from: &Path,
    folder: &Path,
    arrivals: &Arrivals,
    counts: &mut Counts,
) -> anyhow::Result<()> {
    let mut reader = McapReader::open(from)?;
    let mut tables: BTreeMap<CameraId, BTreeMap<u64, String>> = BTreeMap::new();
    while let Some(message) = reader.next_message()? {
        let camera = image::camera_of(&message.channel.topic);
        let camera = camera.filter(|_| message.channel.encoding == sextant_ros2::MESSAGE_ENCODING);
        let Some(image) = camera.and_then(|camera| image::decode(&camera, &message.data)) else {
            continue;
        };
        let t_ns = image.capture_ns;
        let table = tables.entry(image.camera.clone()).or_default();
        if table.contains_key(&t_ns) {
            counts.repeated += 1;
            continue;
        }
        let pictures = camera_folder(folder, &image.camera)?.join("data");
        fs::create_dir_all(&pictures).with_context(|| pictures.display().to_string())?;
        let file = pictures.join(format!("{t_ns}.png"));
        fs::write(&file, &image.png).with_context(|| file.display().to_string())?;
        let arrival_ns = arrivals
            .get(&image.camera)
            .and_then(|arrivals| arrivals.get(&t_ns));
        let arrival_ns = arrival_ns.copied().unwrap_or(message.arrival_ns);
        table.insert(t_ns, format!("{t_ns},{t_ns}.png,{arrival_ns}\n"));
        counts.images += 1;
    }
    for (camera, table) in tables {
        let file = camera_folder(folder, &camera)?.join("data.csv");
        let lines: String = table.into_values().collect();
        let text = format!("#timestamp [ns],filename,arrival [ns]\n{lines}");
        fs::write(&file, text).with_context(|| file.display().to_string())?;
    }
    Ok(())
}

fn camera_folder(folder: &Path, camera: &CameraId) -> anyhow::Result<PathBuf> {
    let folder = folder.join(camera.as_str());
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    Ok(folder)
}

/// The error for a missing second path.
///
/// # Errors
/// Always, with [`Exit::Usage`].
pub fn refuse_without_target(from: &Path) -> anyhow::Result<()> {
    let cause = anyhow::anyhow!(
        "{}: to which recording? `sextant convert DIR FILE.mcap` or `sextant convert FILE.mcap DIR`",
        from.display()
    );
    bail!(sextant_process::Failure::new(Exit::Usage, cause))
}

/// The picture as a PNG of 8-bit grey; one that is that already stays as it is. Refuses what replay would refuse.
fn png_of(path: &Path) -> anyhow::Result<Vec<u8>> {
    let picture = read_picture(path).exit_with(Exit::Input)?;
    let bytes = fs::read(path).with_context(|| path.display().to_string())?;
    if is_grey_png(&bytes) {
        return Ok(bytes);
    }
    Ok(grey_png(&picture)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_recordings::{ColourImage, GreyImage, write_colour_png, write_grey_png};

    const RIG: &str = "[[camera]]\nid = \"north\"\nresolution = [4, 3]\n\
        lens = { model = \"pinhole\", fx = 6.0, fy = 6.0, cx = 1.5, cy = 1.0 }\n";
    const DETECTIONS: &str = concat!(
        r#"{"t_ns":5,"arrival_ns":9,"detections":[{"family":"tag36h11","id":3,"corners":[[0.5,0.25],[2.0,0.25],[2.0,1.5],[0.5,1.5]],"corner_covariance":[[0.01,0.0,0.02],[0.01,0.0,0.02],[0.01,0.0,0.02],[0.01,0.0,0.02]]}]}"#,
        "\n",
        r#"{"t_ns":7,"arrival_ns":8,"detections":[]}"#,
        "\n"
    );

    fn converted(from: &Path, to: &Path, rig: Option<&Path>) -> anyhow::Result<()> {
        let conversion = RecordingConversion {
            from,
            to,
            rig,
            objects: &[],
        };
        conversion.run(Format::Json)
    }

    fn same_files(a: &Path, b: &Path, files: &[&str]) {
        for file in files {
            assert_eq!(
                fs::read(a.join(file)).unwrap(),
                fs::read(b.join(file)).unwrap(),
                "{file}"
            );
        }
    }

    #[test]
    fn a_folder_of_images_comes_back_byte_for_byte() {
        let folder = tempfile::tempdir().unwrap();
        let [from, file, to] = ["from", "a.mcap", "to"].map(|name| folder.path().join(name));
        fs::create_dir_all(from.join("north/data")).unwrap();
        let table = "#timestamp [ns],filename,arrival [ns]\n5,5.png,9\n7,7.png,8\n";
        fs::write(from.join("north/data.csv"), table).unwrap();
        for (name, grey) in [("5.png", 10), ("7.png", 200)] {
            let image = GreyImage {
                width: 4,
                height: 3,
                pixels: (0..12).map(|k| grey + k).collect(),
            };
            write_grey_png(&from.join("north/data").join(name), &image).unwrap();
        }
        converted(&from, &file, None).unwrap();
        converted(&file, &to, None).unwrap();
        same_files(
            &from,
            &to,
            &["north/data.csv", "north/data/5.png", "north/data/7.png"],
        );
        let again = converted(&from, &file, None).unwrap_err();
        assert!(
            format!("{again:#}").contains("choose a new name"),
            "{again:#}"
        );
    }

    #[test]
    fn a_colour_picture_becomes_grey() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let colours = ColourImage {
            width: 2,
            height: 1,
            pixels: vec![255, 0, 0, 9, 9, 9],
        };
        write_colour_png(&path, &colours).unwrap();
        fs::write(folder.path().join("grey"), png_of(&path).unwrap()).unwrap();
        let grey = read_picture(&folder.path().join("grey")).unwrap();
        assert_eq!(grey.pixels, [76, 9]);
        assert!(is_grey_png(&png_of(&path).unwrap()));
    }

    #[test]
    fn detections_and_the_rig_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let [from, file, to, rig] =
            ["from", "a.mcap", "to", "rig.toml"].map(|name| folder.path().join(name));
        fs::create_dir_all(from.join("north")).unwrap();
        fs::write(from.join("north/detections.jsonl"), DETECTIONS).unwrap();
        fs::write(&rig, RIG).unwrap();
        let error = converted(&from, &file, None).unwrap_err();
        assert!(format!("{error:#}").contains("--rig"), "{error:#}");
        fs::remove_file(&file).unwrap();
        converted(&from, &file, Some(&rig)).unwrap();
        converted(&file, &to, None).unwrap();
        same_files(&from, &to, &["north/detections.jsonl"]);
        assert_eq!(
            read_rig(&to.join("rig.toml")).unwrap(),
            read_rig(&rig).unwrap()
        );
    }
}
