//! A comparison as a table for people.

use sextant_evaluation::{Alignment, ObjectComparison, Spread};

/// The comparison, a line an object.
pub fn table(comparisons: &[ObjectComparison], alignment: Alignment) -> String {
    let aligned = match alignment {
        Alignment::None => {
            "not aligned: both are in one world frame (--align rigid allows for another)"
        }
        Alignment::Rigid => "aligned by one rigid motion of the whole world",
    };
    let mut lines = vec![
        format!("against the reference, {aligned}:"),
        format!(
            "{:<16} {:>7}  {:<31}  {:<31}  {:>6}  {:>6}",
            "object",
            "poses",
            "position mm: rms, median, p95, max",
            "attitude deg",
            "NEES",
            "in 95%"
        ),
    ];
    for one in comparisons {
        let spread = |spread: &Spread, digits: usize| {
            let values = [spread.rms, spread.median, spread.p95, spread.max];
            let values = values.map(|value| format!("{value:7.digits$}"));
            values.join(" ")
        };
        lines.push(format!(
            "{:<16} {:>7}  {:<34}  {:<31}  {:>6.2}  {:>5.1}%",
            one.object.as_str(),
            one.compared,
            spread(&one.position_mm, 2),
            spread(&one.attitude_deg, 3),
            one.nees,
            100.0 * one.within_95
        ));
        if one.without_reference > 0 {
            lines.push(format!(
                "{:<16} {} poses have no reference within 0.2 s",
                "", one.without_reference
            ));
        }
    }
    lines.push(
        "NEES is 6 where covariances are right, and 95 % of the poses are in their 95 % region."
            .to_owned(),
    );
    lines.join("\n")
}
