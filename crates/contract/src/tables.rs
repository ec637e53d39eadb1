//! The tables of keys and kinds.

use crate::{KeyRow, KindRow, Unreadable};

pub(crate) fn keys(page: &str) -> Result<Vec<KeyRow>, Unreadable> {
    let rows = rows(page, "| key | message, kind |")?;
    rows.iter().map(|row| key(row)).collect()
}

pub(crate) fn kinds(page: &str) -> Result<Vec<KindRow>, Unreadable> {
    let rows = rows(page, "| kind | message | bytes |")?;
    rows.iter().map(|row| kind(row)).collect()
}

fn key(row: &[String]) -> Result<KeyRow, Unreadable> {
    let [key, message, ..] = row else {
        return Err(unreadable(row));
    };
    let message = match message.as_str() {
        "liveliness token" => None,
        text => {
            let named = text.split_once(", ");
            let (name, kind) = named.ok_or_else(|| unreadable(row))?;
            Some((name.to_owned(), number(kind, row)?))
        }
    };
    let key = key.trim_matches('`').to_owned();
    Ok(KeyRow { key, message })
}

fn kind(row: &[String]) -> Result<KindRow, Unreadable> {
    let [kind, message, max_bytes] = row else {
        return Err(unreadable(row));
    };
    Ok(KindRow {
        number: number(kind, row)?,
        message: message.clone(),
        max_bytes: number(max_bytes, row)?,
    })
}

fn number<T: std::str::FromStr>(text: &str, row: &[String]) -> Result<T, Unreadable> {
    text.parse().map_err(|_| unreadable(row))
}

fn unreadable(row: &[String]) -> Unreadable {
    Unreadable(format!(
        "the row {row:?} is not like the others of its table"
    ))
}

/// The cells of the table with this head, without head and rule.
fn rows(page: &str, head: &str) -> Result<Vec<Vec<String>>, Unreadable> {
    let rows = page
        .lines()
        .skip_while(|line| !line.starts_with(head))
        .take_while(|line| line.starts_with('|'));
    let cells = |row: &str| {
        let cells = row.trim_matches('|').split('|');
        cells.map(|cell| cell.trim().to_owned()).collect()
    };
    let rows: Vec<Vec<String>> = rows.skip(2).map(cells).collect();
    if rows.is_empty() {
        return Err(Unreadable(format!("no table with the head {head}")));
    }
    Ok(rows)
}
