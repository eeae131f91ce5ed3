from pbpf_drake.results.input_usage import FormatUsage, usage_entries

ROWS = [
    ("/joint_states", "", 100, 100, {}),
    (
        "/dope/detected_objects",
        "box",
        46,
        5,
        {"older than 0.25 s": 40, "with a bad pose": 1, "of no kind": 0},
    ),
]


def test_a_table_says_what_was_read_and_used_and_why_not():
    lines = FormatUsage(ROWS).splitlines()
    header, rule, joints, box, *reasons = lines
    assert header.split() == ["input", "object", "read", "used", "left", "out"]
    assert joints.split() == ["/joint_states", "-", "100", "100", "0"]
    assert box.split() == ["/dope/detected_objects", "box", "46", "5", "41"]
    assert len(header) == len(rule) == len(joints) == len(box)
    assert reasons == [
        "/dope/detected_objects (box): left out 40 older than 0.25 s",
        "/dope/detected_objects (box): left out 1 with a bad pose",
    ]


def test_without_input_there_is_no_table():
    assert FormatUsage([]) == ""


def test_entries_name_all_parts():
    joints, box = usage_entries(ROWS)
    assert joints["left_out"] == {} and joints["object"] == ""
    assert (box["source"], box["read"], box["used"]) == (ROWS[1][0], 46, 5)
    assert box["left_out"] == ROWS[1][4]
