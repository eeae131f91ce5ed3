from pbpf_drake.bags.log_notes import LogNotes, plural


def test_plural():
    assert plural(0, "chunk") == "0 chunks"
    assert plural(1, "chunk") == "1 chunk"
    assert plural(2, "chunk") == "2 chunks"


def test_equal_notes_are_one_sentence():
    notes = LogNotes()
    notes.Count("/a", "left out", "message", "without a name")
    notes.Add("A sentence")
    notes.Count("/b", "left out", "message", "without a name")
    notes.Count("/a", "left out", "message", "without a name")
    assert notes.Sentences() == (
        "A sentence",
        "/a: left out 2 messages without a name",
        "/b: left out 1 message without a name",
    )


def test_what_is_counted_on_a_topic_is_counted_with_all_the_rest():
    notes = LogNotes()
    dut = notes.On("/a", "pose")
    notes.Count("/b", "left out", "message", "without a name")
    dut.CountLeftOut("without a name")
    notes.On("/a", "pose").CountLeftOut("without a name")
    dut.Count("turned", "upside down")
    dut.Add("a sentence")
    assert notes.Sentences() == (
        "/a: a sentence",
        "/b: left out 1 message without a name",
        "/a: left out 2 poses without a name",
        "/a: turned 1 pose upside down",
    )


def test_what_is_left_out_is_known_by_object_and_said_together():
    notes = LogNotes()
    dut = notes.On("/a", "detection")
    for owner, count in (("box", 2), ("can", 1), ("", 1)):
        for _ in range(count):
            dut.Of(owner).CountLeftOut("without a name")
    dut.Of("box").Count("turned", "upside down")
    dut.Of("box").CountLeftOut("too late")
    notes.On("/a", "message").Of("box").CountLeftOut("damaged")
    assert dut.Of("box").LeftOut() == {"without a name": 2, "too late": 1}
    assert dut.Of("can").LeftOut() == dut.LeftOut() == {"without a name": 1}
    assert dut.Of("mug").LeftOut() == {}
    assert "/a: left out 4 detections without a name" in notes.Sentences()
