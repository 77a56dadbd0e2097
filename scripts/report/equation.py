"""An equation as cases write it, "Re = u_f d/nu", as it is printed: letters italic, Greek, raised and lowered."""

import re

from markupsafe import Markup, escape

GREEK = dict(
    alpha="α", beta="β", gamma="γ", delta="δ", epsilon="ε", zeta="ζ", eta="η", theta="θ", kappa="κ", lambda_="λ", mu="μ", nu="ν",
    xi="ξ", pi="π", rho="ρ", sigma="σ", tau="τ", phi="φ", chi="χ", psi="ψ", omega="ω",
)  # fmt: skip
GREEK["lambda"] = GREEK.pop("lambda_")
SIGNS = dict(sum="Σ", int="∫", grad="∇", sqrt="√", inf="∞")
OPERATORS = {"->": "→", "<=": "≤", ">=": "≥", "...": "…", "~": "∼", "*": "·", "-": "−", "'": "′"}
UPRIGHT = {"Re", "St", "ln", "an", "as", "at", "by", "in", "is", "it", "no", "of", "on", "or", "to"}  # of two letters
TOKEN = re.compile(
    r"(?P<word>[^\W\d_]+)(?P<digits>\d*)"
    r"|\^(?P<raised>\((?:[^()]|\([^()]*\))*\)|-?\w+)"
    r"|_(?P<lowered>\w+(?:,[a-z](?!\w))?)"
    r"|(?P<times>(?<=\d) x (?=\d))"
    r"|(?P<hyphen>(?<=[^\W\d_]{3})-(?=[^\W\d_]{3}))"
    r"|(?P<of>(?<=\w)'s\b)"
    r"|(?P<operator>->|<=|>=|\.\.\.|[~*'-])"
)


def word_of(word, follows):
    """A word, and whether it is a letter of the formula; "a" before a word of the language is one itself."""
    if word in GREEK:
        return GREEK[word], word != "pi"
    if word in SIGNS:
        return SIGNS[word], False
    next_word = re.match(r" ([a-z]{3,})", follows)
    article = word == "a" and next_word and next_word[1] not in GREEK.keys() | SIGNS.keys()
    return word, len(word) < 3 and word not in UPRIGHT and not article


def typeset(text):
    made, at = [], 0
    for token in TOKEN.finditer(text):
        made.append(escape(text[at : token.start()]))
        at = token.end()
        kind, value = token.lastgroup, token[0]
        if token["word"]:
            word, is_letter = word_of(token["word"], text[at:])
            made.append(Markup("<i>{}</i>" if is_letter else "{}").format(word))
            if token["digits"]:
                made.append(Markup("<sub>{}</sub>").format(token["digits"]))
        elif kind == "raised":
            inside = token["raised"]
            made.append(Markup("<sup>{}</sup>").format(typeset(inside[1:-1] if inside.startswith("(") else inside)))
        elif kind == "lowered":
            name = token["lowered"]  # "int" is a word here
            made.append(Markup("<sub>{}</sub>").format(name if name in SIGNS.keys() - {"inf"} else typeset(name)))
        else:
            made.append({"times": " × ", "hyphen": "-", "of": "’s"}.get(kind) or OPERATORS[value])
    return Markup("").join([*made, escape(text[at:])])
