//! The table of sentences of an enum.

/// Makes `Display` of a type by a table. A row is a variant, what it says, what to do (with the punctuation before it),
/// and the values that both name beside the variant's fields.
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

pub(crate) use sentences;
