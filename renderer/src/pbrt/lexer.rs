//! Text to tokens, forgiving about what copying from a PDF or a word processor does to text.

use std::borrow::Cow;

use logos::Logos;

use super::log::{Log, Pos, shown};
use crate::error::Error;

/// A token of a scene file. Quotes may be straight or typographic: the double kinds close each
/// other, and so do the single kinds, because a PDF often has them mixed.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(skip r"[\s\u{ad}\u{200b}-\u{200f}\u{2060}\u{feff}]+")]
#[logos(skip(r"#[^\r\n]*", allow_greedy = true))]
pub(super) enum Token {
    /// `[`
    #[token("[")]
    Open,
    /// `]`
    #[token("]")]
    Close,
    /// Text in quotes, quotes included. It may run over line ends.
    #[regex(r#"["“”„‟«»″]([^"“”„‟«»″\\]|\\(?s:.))*["“”„‟«»″]"#)]
    #[regex(r#"['‘’‚‛′]([^'‘’‚‛′\\]|\\(?s:.))*['‘’‚‛′]"#)]
    Quoted,
    /// Text whose closing quote is missing, up to the end of the file.
    #[regex(r#"["“”„‟«»″]([^"“”„‟«»″\\]|\\(?s:.))*\\?"#, allow_greedy = true)]
    #[regex(r#"['‘’‚‛′]([^'‘’‚‛′\\]|\\(?s:.))*\\?"#, allow_greedy = true)]
    Unclosed,
    /// Anything else up to a space, quote, bracket or comment: a directive, a number, `true`.
    #[regex(r#"[^\s\[\]#"“”„‟«»″'‘’‚‛′\u{ad}\u{200b}-\u{200f}\u{2060}\u{feff}]+"#)]
    Word,
}

/// The next token of `text` from byte `offset` on, and its byte range. A lexer has no state of its
/// own, so a pair of text and offset is all that the parser must keep.
pub(super) fn next_token(text: &str, offset: usize) -> Option<(Option<Token>, std::ops::Range<usize>)> {
    let mut lexer = Token::lexer(text.get(offset..)?);
    let token = lexer.next()?.ok();
    let span = lexer.span();
    Some((token, offset + span.start..offset + span.end))
}

/// The content of a [`Token::Quoted`]: quotes removed, a line break in the middle (with the spaces
/// around it) made one space, `\"` and `\\` resolved, no-break spaces, ligatures and soft hyphens of
/// typeset text undone.
pub(super) fn unquote(raw: &str, at: Pos, log: &mut Log) -> String {
    let mut chars = raw.chars();
    let (open, close) = (chars.next(), chars.next_back());
    if [open, close].into_iter().flatten().any(|c| c != '"') {
        log.warn_once("typographic quotes", at, "typographic or single quotes, read as \"");
    }
    let mut out = String::with_capacity(raw.len());
    let mut chars = chars.as_str().chars().peekable();
    while let Some(c) = chars.next() {
        let ligature = match c {
            'ﬀ' => "ff",
            'ﬁ' => "fi",
            'ﬂ' => "fl",
            'ﬃ' => "ffi",
            'ﬄ' => "ffl",
            _ => "",
        };
        if !ligature.is_empty() {
            log.warn_once("ligatures", at, format!("ligature '{c}', read as {ligature}"));
            out.push_str(ligature);
        } else if c.is_whitespace() {
            let (mut spaces, mut broken) = (1, c == '\n');
            while let Some(c) = chars.next_if(|c| c.is_whitespace()) {
                spaces += 1;
                broken |= c == '\n';
            }
            out.extend(std::iter::repeat_n(' ', if broken { 1 } else { spaces }));
        } else if is_invisible(c) {
            // A place where typesetting may break the line; never part of a name.
        } else if c == '\\' && chars.peek().is_some_and(|&n| n == '"' || n == '\\') {
            out.extend(chars.next());
        } else {
            out.push(c);
        }
    }
    out
}

fn is_invisible(c: char) -> bool {
    matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}')
}

/// True if a word wants to be a number (even if it fails to be one), rather than a name.
pub(super) fn looks_like_number(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | '\u{2212}' | '\u{2013}'))
}

/// True for what programs write for numbers that are none.
pub(super) fn is_no_number(word: &str) -> bool {
    let word = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    matches!(word.as_str(), "nan" | "inf" | "infinity") || word.starts_with("nan(")
}

/// The number that a word says: `None` if that is none or too large to reckon with. Typographic minus signs are read as
/// such, with a warning. What is no number at all is an error.
pub(super) fn number(word: &str, at: Pos, log: &mut Log) -> Result<Option<f64>, Error> {
    let mut ascii = Cow::Borrowed(word);
    if word.contains(['\u{2212}', '\u{2013}']) {
        log.warn_once("typographic minus", at, "typographic minus sign or dash, read as -");
        ascii = Cow::Owned(word.replace(['\u{2212}', '\u{2013}'], "-"));
    }
    if is_no_number(&ascii) {
        return Ok(None);
    }
    match ascii.parse::<f64>() {
        Ok(v) => Ok(Some(v).filter(|v| v.abs() <= f64::from(f32::MAX))),
        Err(_) => Err(log.error(at, format!("found {}, expected a number", shown(word)))),
    }
}
