//! Prior of a value in a model: what is known of its error.

/// Prior of a value: the standard deviation `S` of its error, if known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Prior<S> {
    /// Nothing is given: fusion and calibration apply their defaults, which docs/models.md lists.
    #[default]
    Default,
    /// The value is exact, as in simulations. Files and messages write it as a standard deviation of zero.
    Exact,
    /// Standard deviation; not zero in a checked [`crate::Rig`] or [`crate::ObjectModel`].
    Sigma(S),
}

/// A standard deviation, of one number or several.
pub trait Deviation: Copy + PartialEq {
    /// That of an exact value.
    const ZERO: Self;
}

impl Deviation for f64 {
    const ZERO: Self = 0.0;
}

impl<S: Deviation> Prior<S> {
    /// The standard deviation as files and messages have it: zero if exact, `None` if not given.
    pub fn given(self) -> Option<S> {
        match self {
            Self::Default => None,
            Self::Exact => Some(S::ZERO),
            Self::Sigma(sigma) => Some(sigma),
        }
    }

    /// The standard deviation, with the caller's default where none is given.
    pub fn sigma_or(self, default: S) -> S {
        self.given().unwrap_or(default)
    }

    /// This prior, or the other one where nothing is given.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        match self {
            Self::Default => other,
            given => given,
        }
    }
}

impl<S: Deviation> From<Option<S>> for Prior<S> {
    /// Inverse of [`Prior::given`]: zero is exact.
    fn from(given: Option<S>) -> Self {
        match given {
            None => Self::Default,
            Some(sigma) if sigma == S::ZERO => Self::Exact,
            Some(sigma) => Self::Sigma(sigma),
        }
    }
}
