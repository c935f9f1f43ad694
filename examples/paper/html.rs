//! Parts of an HTML page that needs nothing else: text, tables, pictures within the page.

use std::fs;
use std::io;
use std::path::Path;

/// Text as HTML shows it.
pub fn text(plain: &str) -> String {
    let mut out = String::with_capacity(plain.len());
    for c in plain.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c => out.push(c),
        }
    }
    out
}

/// A table with a heading for each column. Cells are plain text.
pub fn table(heads: &[&str], rows: &[Vec<String>]) -> String {
    let cells = |name: &str, cells: &mut dyn Iterator<Item = String>| {
        let cells: String = cells
            .map(|cell| format!("<{name}>{cell}</{name}>"))
            .collect();
        format!("<tr>{cells}</tr>\n")
    };
    let head = cells("th", &mut heads.iter().map(|head| text(head)));
    let body: String = rows
        .iter()
        .map(|row| cells("td", &mut row.iter().map(|cell| text(cell))))
        .collect();
    format!("<table>\n<thead>{head}</thead>\n<tbody>\n{body}</tbody>\n</table>\n")
}

/// A PNG file within the page.
///
/// # Errors
/// Those of reading the file.
pub fn picture(file: &Path, caption: &str) -> io::Result<String> {
    let (data, caption) = (base64(&fs::read(file)?), text(caption));
    Ok(format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
    ))
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * i)) as usize & 63];
            out.push(if i <= chunk.len() {
                letter as char
            } else {
                '='
            });
        }
    }
    out
}

/// A whole page.
pub fn page(title: &str, body: &str) -> String {
    let (title, style) = (text(title), include_str!("report.css"));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n{style}</style>\n\
         </head>\n<body>\n<h1>{title}</h1>\n{body}</body>\n</html>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors of RFC 4648.
    #[test]
    fn bytes_are_encoded_as_the_standard_says() {
        let vectors = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, encoded) in vectors {
            assert_eq!(base64(plain.as_bytes()), encoded);
        }
        assert_eq!(base64(&[0xff, 0xef, 0xfe]), "/+/+");
    }

    #[test]
    fn text_cannot_open_a_tag() {
        let table = table(&["a < b"], &[vec!["<img src=\"x\"> & y".to_owned()]]);
        assert!(table.contains("a &lt; b"));
        assert!(table.contains("&lt;img src=&quot;x&quot;&gt; &amp; y"));
    }
}
