//! The text format of Prometheus (prometheus.io, "Exposition formats", version 0.0.4): a family of samples has a help
//! line, a type line and a line a sample.

use super::histogram::{BOUNDS_S, Histogram};
use std::fmt::Write;

/// A family under way.
pub(super) struct Family<'a> {
    text: &'a mut String,
    name: &'static str,
}

/// What a family's samples are.
#[derive(Debug, Clone, Copy)]
pub(super) enum FamilyKind {
    Counter,
    Gauge,
    Histogram,
}

/// A label and its value.
pub(super) type Label<'a> = (&'static str, &'a str);

/// Begins a family.
pub(super) fn family<'a>(
    text: &'a mut String,
    name: &'static str,
    kind: FamilyKind,
    help: &str,
) -> Family<'a> {
    let kind = match kind {
        FamilyKind::Counter => "counter",
        FamilyKind::Gauge => "gauge",
        FamilyKind::Histogram => "histogram",
    };
    // Writing into a string cannot fail.
    let _ = writeln!(text, "# HELP {name} {help}\n# TYPE {name} {kind}");
    Family { text, name }
}

impl Family<'_> {
    /// Adds a sample. What is not finite says nothing and is left out.
    pub(super) fn sample(&mut self, labels: &[Label<'_>], value: f64) {
        self.line("", labels, value);
    }

    /// Adds a histogram.
    pub(super) fn histogram(&mut self, labels: &[Label<'_>], histogram: &Histogram) {
        let bounds = BOUNDS_S.iter().map(f64::to_string);
        let counts = histogram.cumulative().into_iter();
        let buckets = bounds.zip(counts);
        let last = ("+Inf".to_owned(), histogram.count());
        for (bound, count) in buckets.chain([last]) {
            let labels = [labels, &[("le", bound.as_str())]].concat();
            self.line("_bucket", &labels, count as f64);
        }
        self.line("_sum", labels, histogram.sum_s());
        self.line("_count", labels, histogram.count() as f64);
    }

    fn line(&mut self, suffix: &str, labels: &[Label<'_>], value: f64) {
        if !value.is_finite() {
            return;
        }
        self.text.push_str(self.name);
        self.text.push_str(suffix);
        for (n, (label, value)) in labels.iter().enumerate() {
            let before = if n == 0 { '{' } else { ',' };
            let _ = write!(self.text, "{before}{label}=\"{}\"", escaped(value));
        }
        let after = if labels.is_empty() { "" } else { "}" };
        let _ = writeln!(self.text, "{after} {value}");
    }
}

/// A label's value between quotes.
fn escaped(value: &str) -> String {
    let parts = value.chars().map(|c| match c {
        '\\' => "\\\\".to_owned(),
        '"' => "\\\"".to_owned(),
        '\n' => "\\n".to_owned(),
        other => other.to_string(),
    });
    parts.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_is_help_type_and_samples() {
        let mut text = String::new();
        let mut family = family(&mut text, "a_total", FamilyKind::Counter, "How many.");
        family.sample(&[], 3.0);
        family.sample(&[("b", "x\"\\\n"), ("c", "y")], 0.5);
        family.sample(&[], f64::NAN);
        assert_eq!(
            text,
            "# HELP a_total How many.\n# TYPE a_total counter\na_total 3\na_total{b=\"x\\\"\\\\\\n\",c=\"y\"} 0.5\n"
        );
    }

    #[test]
    fn buckets_are_cumulative() {
        let mut histogram = Histogram::default();
        for ms in [1, 3, 3, 60_000] {
            histogram.take(5, 5 + ms * 1_000_000).unwrap();
        }
        assert!(histogram.take(2, 1).is_err());
        let mut text = String::new();
        let mut family = family(&mut text, "h", FamilyKind::Histogram, "H.");
        family.histogram(&[], &histogram);
        for line in [
            "h_bucket{le=\"0.001\"} 1\n",
            "h_bucket{le=\"0.002\"} 1\n",
            "h_bucket{le=\"0.005\"} 3\n",
            "h_bucket{le=\"5\"} 3\n",
            "h_bucket{le=\"+Inf\"} 4\n",
            "h_count 4\n",
        ] {
            assert!(text.contains(line), "{line} of {text}");
        }
    }
}
