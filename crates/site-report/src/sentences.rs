//! Enums of which each variant is a sentence.

/// Makes `Display` of a type by a table. A row is a variant, what it says, what to do (with the punctuation before it),
/// and the values that both name beside the variant's fields.
///
/// ```
/// enum Trouble {
///     Off { by_m: f64 },
/// }
/// sextant_site_report::sentences! { Trouble {
///     Self::Off { by_m } => "it is off by {mm:.1} mm", ": push it back", mm = by_m * 1e3;
/// }}
/// assert_eq!(Trouble::Off { by_m: 0.002 }.to_string(), "it is off by 2.0 mm: push it back");
/// ```
#[macro_export]
macro_rules! sentences {
    ($type:ident {
        $($row:pat $(if $case:expr)? =>
            $text:literal, $remedy:literal $(, $name:ident = $value:expr)*;)*
    }) => {
        impl ::std::fmt::Display for $type {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                match self {
                    $($row $(if $case)? => {
                        $(let $name = $value;)*
                        write!(f, $text)?;
                        write!(f, $remedy)
                    })*
                }
            }
        }
    };
}
