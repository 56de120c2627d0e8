//! Rust text without what is no code.

/// The text with every comment, string and character blanked out; lines stay where they are.
pub fn code_of(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let before = code.chars().next_back();
        let length = not_code(rest, before).unwrap_or(0);
        let skipped = &rest[..length.max(next.len_utf8())];
        match length {
            0 => code.push(next),
            _ => code.extend(skipped.chars().map(|c| if c == '\n' { '\n' } else { ' ' })),
        }
        rest = &rest[skipped.len()..];
    }
    code
}

/// The bytes of the comment, string or character at the start of the text, if there is one.
fn not_code(text: &str, before: Option<char>) -> Option<usize> {
    if text.starts_with("//") {
        return Some(text.find('\n').unwrap_or(text.len()));
    }
    if text.starts_with("/*") {
        return Some(block_comment(text));
    }
    let in_a_name = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let prefixed = text.trim_start_matches(['b', 'c', 'r']);
    let prefix = text.len() - prefixed.len();
    if prefix > 2 || (prefix > 0 && in_a_name) {
        return None;
    }
    if text[..prefix].ends_with('r') {
        return raw_string(prefixed).map(|length| prefix + length);
    }
    match prefixed.chars().next()? {
        '"' => Some(prefix + quoted(prefixed, '"')),
        '\'' => character(prefixed).map(|length| prefix + length),
        _ => None,
    }
}

fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let rest = &text[at..];
        let step = match (rest.starts_with("/*"), rest.starts_with("*/")) {
            (true, _) => {
                depth += 1;
                2
            }
            (_, true) => {
                depth -= 1;
                2
            }
            _ => rest.chars().next().map_or(1, char::len_utf8),
        };
        at += step;
        if depth == 0 {
            break;
        }
    }
    at.min(text.len())
}

fn raw_string(text: &str) -> Option<usize> {
    let content = text.trim_start_matches('#');
    let hashes = &text[..text.len() - content.len()];
    let end = format!("\"{hashes}");
    let length = content.strip_prefix('"')?.find(&end)?;
    Some(hashes.len() + 1 + length + end.len())
}

/// Up to and with the closing quote that no backslash stands before.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// A character, not a lifetime: it has a closing quote after one character or an escape.
fn character(text: &str) -> Option<usize> {
    let inner = &text[1..];
    let first = inner.chars().next()?;
    let closes = inner[first.len_utf8()..].starts_with('\'');
    (first == '\\' || (closes && first != '\'')).then(|| quoted(text, '\''))
}

/// Code without the tests that stand, by the rule of the house, at its end.
pub fn without_tests(code: &str) -> &str {
    let tests = code.find("#[cfg(test)]\nmod tests");
    &code[..tests.unwrap_or(code.len())]
}

/// Whether a word stands in the code by itself, not as a part of a longer name.
pub fn has_word(code: &str, word: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let after = code[at + word.len()..].chars().next();
        !before.is_some_and(is_name) && !after.is_some_and(is_name)
    })
}

#[cfg(test)]
mod tests {
    use super::{code_of, has_word, without_tests};

    #[track_caller]
    fn check(text: &str, word_is_code: bool) {
        let code = code_of(text);
        assert_eq!(has_word(&code, "unsafe"), word_is_code, "{text:?} became {code:?}");
        assert_eq!(code.lines().count(), text.lines().count(), "{text:?}");
    }

    #[test]
    fn code_is_found() {
        check("unsafe { x() }", true);
        check("let c = '\"'; unsafe {} let d = '\"';", true);
        check("fn f<'a>(x: &'a str) { unsafe {} } // 'b'", true);
        check("let s = \"a\\\"\"; unsafe {}", true);
        check("let s = r#\"\"quoted\"\"#; unsafe {}", true);
        check("let s = b\"\\\\\"; unsafe {}", true);
        check("/* a /* b */ c */ unsafe {}", true);
        check("let number = var\"x\"; unsafe {}", true);
    }

    #[test]
    fn what_is_no_code_is_not() {
        check("// unsafe\n/// unsafe\n//! unsafe\nfn f() {}", false);
        check("/* a /* unsafe */ unsafe */", false);
        check("let s = \"unsafe \\\" unsafe\";", false);
        check("let s = r#\"unsafe \" unsafe\"#;", false);
        check("let s = br\"unsafe\\\"; let c = 'u';", false);
        check("#![forbid(unsafe_code)]", false);
        check("let s = \"two\nlines of unsafe\nin a string\";", false);
    }

    #[test]
    fn tests_at_the_end_are_left_out() {
        assert_eq!(without_tests("a\n#[cfg(test)]\nmod tests {\n b }"), "a\n");
        assert_eq!(without_tests("#[cfg(test)]\nmod derive;\na"), "#[cfg(test)]\nmod derive;\na");
    }
}
