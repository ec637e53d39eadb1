//! The last seconds of a site from its bridge: the other end of `/api/last.mcap`.

use super::LAST_MCAP;
use crate::http_client;
use anyhow::{Context, anyhow, bail};
use axum::body::Body;
use axum::http::{Request, StatusCode, Uri, header};
use sextant_process::{Exit, Failure, WithExit};
use std::time::Duration;
use tokio::time::timeout;

/// Longest wait for the file.
const PATIENCE: Duration = Duration::from_secs(60);
/// Longest file: what a bridge keeps, with what viewers are shown of it.
const MAX_BYTES: usize = 512 << 20;

/// The recording of the last `seconds` that the bridge with this page makes.
///
/// # Errors
/// [`Exit::Usage`] for what is no plain HTTP address, [`Exit::Input`] where a token is wanted, [`Exit::Unavailable`]
/// without a bridge.
pub fn download_last_seconds(
    page: &str,
    token: Option<&str>,
    seconds: u64,
) -> anyhow::Result<Vec<u8>> {
    let url: Uri = format!(
        "{}{LAST_MCAP}?seconds={seconds}",
        page.trim_end_matches('/')
    )
    .parse()
    .with_context(|| format!("--page {page}"))
    .exit_with(Exit::Usage)?;
    if url.scheme_str() != Some("http") || url.host().is_none() {
        let cause = anyhow!(
            "--page {page}: write http://HOST:PORT; of a page with TLS, save the recording with \
             a browser, or run this on the bridge's machine"
        );
        bail!(Failure::new(Exit::Usage, cause));
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()?;
    runtime.block_on(async {
        timeout(PATIENCE, get(&url, page, token))
            .await
            .map_err(|_| anyhow!("{page} does not answer"))
            .exit_with(Exit::Unavailable)?
    })
}

async fn get(url: &Uri, page: &str, token: Option<&str>) -> anyhow::Result<Vec<u8>> {
    let path = url.path_and_query().map_or("/", |path| path.as_str());
    let mut request = Request::get(path);
    if let Some(token) = token {
        request = request.header(header::AUTHORIZATION, format!("Bearer {token}"));
    }
    let answer = http_client::send(url, request, Body::empty())
        .await
        .with_context(|| {
            format!("no page at {page}: start a viewer bridge, or name its page with --page")
        })
        .exit_with(Exit::Unavailable)?;
    match answer.status() {
        StatusCode::OK => {}
        StatusCode::UNAUTHORIZED | StatusCode::TOO_MANY_REQUESTS => {
            let cause = anyhow!(
                "{page} wants a token: give one of its page-tokens.toml in SEXTANT_PAGE_TOKEN"
            );
            bail!(Failure::new(Exit::Input, cause));
        }
        status => {
            let cause = anyhow!("{page} answered {status}: is it the page of a viewer bridge?");
            bail!(Failure::new(Exit::Unavailable, cause));
        }
    }
    let file = axum::body::to_bytes(Body::new(answer.into_body()), MAX_BYTES).await;
    let file = file.context("the connection broke; try again");
    Ok(file.exit_with(Exit::Unavailable)?.into())
}
