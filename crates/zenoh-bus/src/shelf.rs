//! Values under several keys that belong together: a query gets all of one state.

use std::sync::{Arc, Mutex, PoisonError};

use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::key_expr::KeyExpr;

use crate::BusError;

/// Answers queries until it is dropped.
#[derive(Debug)]
pub struct Shelf {
    root: String,
    values: Arc<Mutex<Arc<Values>>>,
    _queryable: zenoh::query::Queryable<()>,
}

type Values = Vec<(KeyExpr<'static>, ZBytes)>;

impl Shelf {
    pub(crate) fn declare(session: &zenoh::Session, root: &str) -> Result<Self, BusError> {
        let values = Arc::new(Mutex::new(Arc::new(Values::new())));
        let key_expr = format!("{root}/**");
        let queryable = {
            let values = Arc::clone(&values);
            let declared = session.declare_queryable(key_expr.clone());
            declared.callback(move |query| {
                let values = Arc::clone(&values.lock().unwrap_or_else(PoisonError::into_inner));
                answer(&query, &values);
            })
        };
        Ok(Self {
            root: root.to_owned(),
            values,
            _queryable: (queryable.wait()).map_err(|cause| BusError::of_key(&key_expr, &cause))?,
        })
    }

    /// Replaces all values: payloads under keys below the root.
    ///
    /// # Errors
    /// A key that is none.
    pub fn replace<'a>(
        &self,
        values: impl IntoIterator<Item = (&'a str, &'a [u8])>,
    ) -> Result<(), BusError> {
        let value = |(below, payload): (&str, &[u8])| {
            let key = format!("{}/{below}", self.root);
            let expression = KeyExpr::new(key.clone());
            let expression = expression.map_err(|cause| BusError::of_key(&key, &cause))?;
            Ok((expression, ZBytes::from(payload.to_vec())))
        };
        let values = values.into_iter().map(value);
        let values: Values = values.collect::<Result<_, BusError>>()?;
        *self.values.lock().unwrap_or_else(PoisonError::into_inner) = Arc::new(values);
        Ok(())
    }
}

fn answer(query: &zenoh::query::Query, values: &Values) {
    let asked = values
        .iter()
        .filter(|(key, _)| query.key_expr().intersects(key));
    for (key, payload) in asked {
        if let Err(cause) = query.reply(key, payload.clone()).wait() {
            tracing::debug!(%key, %cause, "a query went away before its answer");
            return;
        }
    }
}
