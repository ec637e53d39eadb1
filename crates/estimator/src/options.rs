//! The tunables of fusion, each with unit, default, range and reason.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Declares options with default and range, so that a field can't miss either; those of a part in a struct of their own
/// follow.
macro_rules! options {
    ($(#[$about:meta])* $name:ident {
        $($(#[$doc:meta])* $field:ident = $default:literal in $lowest:literal ..= $highest:literal;)*
    } $($(#[$part_doc:meta])* $part:ident: $Part:ident;)?) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $(
                $(#[$doc])*
                #[doc = concat!(
                    "\n\nDefault ", stringify!($default), ", range ",
                    stringify!($lowest), " to ", stringify!($highest), ".",
                )]
                pub $field: f64,
            )*
            $($(#[$part_doc])* pub $part: $Part,)?
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* $($part: $Part::default(),)? }
            }
        }

        impl $name {
            /// Whether each field lies in its range.
            ///
            /// # Errors
            /// For the first field that does not.
            pub fn validate(&self) -> Result<(), OptionsError> {
                $(within(stringify!($field), self.$field, $lowest, $highest)?;)*
                $(self.$part.validate()?;)?
                Ok(())
            }
        }
    };
}

options! {
/// Options of fusion.
FusionOptions {
    /// Seconds of images kept, so that late ones can be inserted: longer than the slowest way to the fusion node, short
    /// enough that a late image costs little.
    window_s = 0.5 in 0.0 ..= 5.0;
    /// Seconds by which a capture time may lie ahead of the present: clocks differ, but an image from the far future
    /// would push everything else out of the window.
    ahead_s = 1.0 in 0.0 ..= 60.0;
    /// Pixels of corner noise (one sigma an axis) of a tag 20 px wide where the detector gives none: other detectors
    /// leave 0.2 to 1 on real images. The noise of each camera is estimated from here.
    corner_sigma_px = 0.2 in 0.001 ..= 10.0;
    /// Pixels added to every reported corner noise: lens and print are never known better.
    corner_floor_px = 0.003 in 0.0 ..= 10.0;
    /// Corner residuals that the estimate of a camera's noise remembers: many for a steady figure, few for a quick one.
    noise_memory = 800.0 in 10.0 ..= 1e6;
    /// Twice the robust cost of a tag's four corners beyond which the tag takes no part. It grows with the logarithm of
    /// the squared residuals: residuals of four sigmas throughout reach this, and count little by then.
    tag_gate = 45.0 in 10.0 ..= 1000.0;
    /// Natural logarithm of the odds against a tag that takes no part: of wrong tags being rare, and of a wrong one
    /// lying just there among all places in the image.
    refused_odds = 35.0 in 5.0 ..= 1000.0;
    /// Chi-square of the prediction (6 degrees of freedom) beyond which the image contradicts it: 99.99 % lie within.
    prediction_gate = 27.9 in 10.0 ..= 1000.0;
    /// m²/s³, power density of the white acceleration to begin with, before the body's own is learned: what a motion of
    /// about 2 m/s² amounts to at 30 images/s.
    linear_acceleration_psd = 0.15 in 1e-9 ..= 1e4;
    /// rad²/s³, power density of the white angular acceleration to begin with: about 7 rad/s² at 30 images/s.
    angular_acceleration_psd = 1.5 in 1e-9 ..= 1e5;
    /// m/s² by which a body may be accelerated between two images against all expectation: hit, dropped, caught.
    linear_jolt = 50.0 in 0.0 ..= 1e4;
    /// rad/s², the same for rotation.
    angular_jolt = 500.0 in 0.0 ..= 1e5;
    /// m/s, one sigma of the speed of an object that has just appeared.
    start_speed = 1.0 in 0.01 ..= 100.0;
    /// rad/s, one sigma of its angular speed.
    start_angular_speed = 4.0 in 0.01 ..= 1000.0;
    /// Natural logarithm of the odds against a jolt between two images.
    jolt_odds = 10.0 in 0.0 ..= 100.0;
    /// Seconds of reported clock error up to which a camera's clock counts as exact: at 1 m/s less than corner
    /// noise.
    right_clock_s = 0.0001 in 0.0 ..= 1.0;
    /// Prior standard deviation of the offset of a clock of which nothing is known, s.
    unknown_clock_s = 0.03 in 0.0001 ..= 1.0;
    /// s²/s by which the offsets wander: 30 µs in a second, as cheap quartzes do.
    clock_wander = 1e-9 in 0.0 ..= 1e-3;
    /// Natural logarithm of the odds beyond which the likeliest attitude counts as the true one.
    trusted_odds = 9.0 in 1.0 ..= 100.0;
    /// Natural logarithm of the odds beyond which an unlikely attitude is given up.
    hopeless_odds = 20.0 in 1.0 ..= 200.0;
    /// Radians (one sigma about the worst axis) beyond which an attitude is too vague to be called tracking.
    vague_attitude = 0.1 in 0.01 ..= 3.0;
    /// Metres (one sigma along the worst axis) beyond which a position is too vague to be called tracking.
    vague_position = 0.1 in 0.001 ..= 10.0;
    /// Seconds without a sight after which images without the object's tags give predicted poses, and the least time
    /// between two of them.
    coasting_s = 0.02 in 0.0 ..= 5.0;
    /// Metres (one sigma along the worst axis) up to which a predicted pose is worth publishing.
    coasting_position = 0.015 in 0.0 ..= 10.0;
    /// Radians (one sigma about the worst axis) up to which a predicted attitude is worth publishing.
    coasting_attitude = 0.1 in 0.0 ..= 3.0;
    /// Seconds without a sight after which an object is lost: a prediction is worth nothing by then.
    lost_s = 0.7 in 0.05 ..= 60.0;
    /// Seconds for which a doubtful attitude is kept back before it is published as such: most doubts are gone by then.
    patience_s = 0.3 in 0.0 ..= 60.0;
    /// Seconds from the first image of an object in which all that images contradict counts as errors of the files, so
    /// that even early poses are corrected. Later images are learned only once diagnosis has judged them.
    learning_s = 2.0 in 0.0 ..= 60.0;
    /// Seconds of contradicting images after which the track starts anew from them.
    contradiction_s = 0.15 in 0.0 ..= 10.0;
}
/// Options of fault diagnosis.
diagnosis: DiagnosisOptions;
}

options! {
/// Options of fault diagnosis: which cameras were moved, which tags are misplaced or of another size, which clocks are
/// off.
DiagnosisOptions {
    /// Seconds of images that are tested jointly: long enough to average noise, short enough that a new fault soon
    /// fills it.
    window_s = 0.8 in 0.1 ..= 10.0;
    /// Seconds between two searches for faults, and between tested images of an object (longer with many), while
    /// nothing is suspected: a fault stays, so that a few suffice.
    quiet_interval_s = 0.1 in 0.0 ..= 10.0;
    /// The same while a fault is suspected: about each instant of usual cameras.
    alert_interval_s = 0.03 in 0.0 ..= 10.0;
    /// Logarithm of the likelihood ratio from which on a fault is suspected, so that more images are tested.
    suspected_odds = 5.0 in 1.0 ..= 1000.0;
    /// Logarithm of the likelihood ratio from which on a fault is named: high, since errors of lenses and prints are in
    /// every image.
    named_odds = 40.0 in 5.0 ..= 1000.0;
    /// Seconds for which a fault must explain most before it is named: a blow to an object lasts for a few images.
    confirmation_s = 0.2 in 0.0 ..= 10.0;
    /// Logarithm of the likelihood ratio below which a named fault is over.
    cleared_odds = 10.0 in 1.0 ..= 1000.0;
    /// Logarithm of the likelihood ratio by which a fault must exceed every alternative; and from which on
    /// self-calibration waits, lest it learn a fault as an error of the files.
    margin_odds = 15.0 in 1.0 ..= 1000.0;
    /// Share of what the alternatives leave unexplained that a fault must explain besides.
    margin_share = 0.3 in 0.0 ..= 1.0;
    /// Share of the contradiction that a fault must explain: errors of the motion between images are in the rest.
    explained_share = 0.3 in 0.0 ..= 1.0;
    /// Radians by which a moved camera displaces what it sees, worth naming: 2.6 mm at 1 m.
    camera_angle = 0.0026 in 0.0 ..= 1.0;
    /// Radians by which a moved camera is turned, worth naming.
    camera_turn = 0.0087 in 0.0 ..= 1.0;
    /// Metres by which a tag is off its place, worth naming: glue and paper are not better.
    tag_position = 0.001 in 0.0 ..= 1.0;
    /// Radians by which a tag is turned, worth naming.
    tag_turn = 0.035 in 0.0 ..= 1.0;
    /// Relative error of a tag's size, worth naming: printers scale by some tenths of a per cent.
    tag_size = 0.01 in 0.0 ..= 1.0;
    /// Pixels by which a lens misses the corners of the image, worth naming.
    lens_corner_px = 3.0 in 0.0 ..= 1000.0;
    /// Seconds by which a clock is off, worth naming: 2 mm at 1 m/s.
    clock_offset = 0.002 in 0.0 ..= 1.0;
}
}

/// A tunable outside of its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{field} = {value} is outside of {lowest} to {highest}")]
pub struct OptionsError {
    /// Name of the field.
    pub field: &'static str,
    /// What it was given.
    pub value: f64,
    /// Lowest value allowed.
    pub lowest: f64,
    /// Highest value allowed.
    pub highest: f64,
}

fn within(field: &'static str, value: f64, lowest: f64, highest: f64) -> Result<(), OptionsError> {
    if (lowest..=highest).contains(&value) {
        Ok(())
    } else {
        Err(OptionsError {
            field,
            value,
            lowest,
            highest,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_lie_in_their_ranges() {
        assert_eq!(FusionOptions::default().validate(), Ok(()));
    }

    #[test]
    fn an_unknown_clock_has_the_prior_of_calibrations() {
        let options = FusionOptions::default();
        assert_eq!(options.unknown_clock_s, sextant_site_model::CLOCK_SIGMA_S);
    }

    #[test]
    fn a_value_that_is_no_number_is_refused_by_name() {
        let options = FusionOptions {
            window_s: f64::NAN,
            ..FusionOptions::default()
        };
        assert_eq!(options.validate().unwrap_err().field, "window_s");
    }
}
