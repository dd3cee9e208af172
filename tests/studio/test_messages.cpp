// SPDX-License-Identifier: Apache-2.0
// Messages: what is read, what is refused with which words, and the bytes of the binary layouts.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>

#include "../refusal.hpp"
#include "haptogram/base/depth.hpp"
#include "local_server.hpp"
#include "messages.hpp"

using namespace haptogram;
using namespace haptogram::studio;
using haptogram::serve::Answer, haptogram::serve::close_reason, haptogram::serve::error_answer,
    haptogram::serve::most_message_bytes;

namespace {

template <class T>
T at(const std::vector<std::uint8_t>& bytes, std::size_t place) {
    T value;
    REQUIRE(place + sizeof value <= bytes.size());
    std::memcpy(&value, bytes.data() + place, sizeof value);
    return value;
}

const std::string slice_text =
    R"({"t":"slice","n":7,"scene":"abc","origin":[-80,-80,130],"u":[160,0,0],"v":[0,160,0],"width":200,"height":100,"record":5,"view":2})";

const std::string study_text =
    R"({"t":"study","n":1,"protocol":"haptogram_shapes","participant":3,"seed":7,"results":"p3.jsonl","port":"/dev/ttyUSB0"})";

}  // namespace

TEST_CASE("studio messages: every kind is read, lengths become metres") {
    const auto slice = std::get<SliceMessage>(read_message(slice_text));
    CHECK(slice.n == 7);
    CHECK(slice.scene == "abc");
    CHECK(slice.slice.origin.x == Approx(-0.08));
    CHECK(slice.slice.origin.z == Approx(0.13));
    CHECK(slice.slice.v.y == Approx(0.16));
    CHECK(slice.slice.width == 200);
    CHECK(slice.slice.height == 100);
    CHECK(slice.record == 5);
    CHECK(slice.view == 2);
    const auto reach = std::get<ReachMessage>(read_message(
        R"({"t":"reach","n":8,"scene":"abc","origin":[0,0,50],"u":[10,0,0],"v":[0,0,20],"width":48,"height":49,"view":3})"));
    CHECK(reach.slice.n == 8);
    CHECK(reach.slice.scene == "abc");
    CHECK(reach.slice.slice.v.z == Approx(0.02));
    CHECK(reach.slice.slice.height == 49);
    CHECK(reach.slice.record == 0);
    CHECK(reach.slice.view == 3);
    const auto skin = std::get<SkinMessage>(
        read_message(R"({"t":"skin","n":9,"scene":"abc","points":[1,2,130,-4.5,0,131],"record":2,"view":3})"));
    CHECK(skin.slice.n == 9);
    CHECK(skin.slice.record == 2);
    CHECK(skin.slice.view == 3);
    CHECK(skin.slice.slice.width == 2);
    CHECK(skin.slice.slice.height == 1);
    REQUIRE(skin.points.size() == 2);
    CHECK(distance(skin.points[1], from_mm(-4.5, 0, 131)) < 1e-15);
    const auto drives = std::get<DrivesMessage>(read_message(R"({"t":"drives","n":6,"scene":"s","record":3})"));
    CHECK(drives.scene == "s");
    CHECK(drives.record == 3);
    CHECK(std::get<AnalyzeMessage>(read_message(R"({"t":"analyze","n":7,"scene":"s"})")).scene == "s");
    CHECK(std::get<SimulateMessage>(read_message(R"({"t":"simulate","n":8,"scene":"s"})")).scene == "s");
    const auto cancel = std::get<CancelMessage>(read_message(R"({"t":"cancel","n":9,"what":"analyze"})"));
    CHECK(cancel.n == 9);
    CHECK(cancel.what == CancelMessage::What::analyze);
    CHECK(std::get<CancelMessage>(read_message(R"({"t":"cancel","n":9,"what":"simulate"})")).what ==
          CancelMessage::What::simulate);
    const auto pulses = std::get<PulsesMessage>(read_message(R"({"t":"pulses","n":10,"index":4,"periods":2})"));
    CHECK(pulses.index == 4);
    CHECK(pulses.periods == 2);
    const auto scene = std::get<SceneMessage>(read_message(R"({"t":"scene","n":1,"document":{"points":9}})"));
    CHECK(scene.document["points"] == 9);
    const auto hand = std::get<HandMessage>(read_message(R"({"t":"hand","n":2,"document":{"points":9},"drawn":"a"})"));
    CHECK(hand.document["points"] == 9);
    CHECK(hand.drawn == "a");
    CHECK(std::get<PathMessage>(read_message(R"({"t":"path","n":3,"document":{"points":9}})")).document["points"] == 9);
    CHECK(std::get<ConnectMessage>(read_message(R"({"t":"connect","n":1,"port":"virtual","scene":"s"})")).port ==
          "virtual");
    CHECK(std::get<ConnectMessage>(read_message(R"({"t":"connect","n":1,"port":"p","scene":"","baud":115200})")).baud ==
          115200);
    CHECK(std::get<DisconnectMessage>(read_message(R"({"t":"disconnect","n":2})")).n == 2);
    CHECK(std::get<UploadMessage>(read_message(R"({"t":"upload","n":3,"scene":"s"})")).scene == "s");
    CHECK(std::get<PlayMessage>(read_message(R"({"t":"play","n":4,"scene":"s"})")).n == 4);
    const auto stream = std::get<StreamMessage>(read_message(R"({"t":"stream","n":5,"scene":"s","index":3})"));
    CHECK(stream.scene == "s");
    CHECK(stream.index == 3);
    CHECK(std::get<IntensityMessage>(read_message(R"({"t":"intensity","n":6,"value":0.25})")).value == 0.25);
    CHECK(std::get<IntensityMessage>(read_message(R"({"t":"intensity","n":6,"value":1})")).value == 1.0);
    CHECK(std::get<ModulateMessage>(read_message(R"({"t":"modulate","n":6,"scene":"ab"})")).scene == "ab");
    CHECK(std::get<StudiesMessage>(read_message(R"({"t":"studies","n":11})")).n == 11);
    const auto study = std::get<StudyMessage>(read_message(study_text));
    CHECK(study.protocol == "haptogram_shapes");
    CHECK(study.participant == 3);
    CHECK(study.seed == 7);
    CHECK(study.results == "p3.jsonl");
    CHECK(study.port == "/dev/ttyUSB0");
    const auto live =
        std::get<LiveMessage>(read_message(R"({"t":"live","n":14,"document":{"points":3},"from":"/tmp/hands"})"));
    CHECK(live.n == 14);
    CHECK(live.document["points"] == 3);
    CHECK(live.from == "/tmp/hands");
    const auto answer =
        std::get<AnswerMessage>(read_message(R"({"t":"answer","n":12,"number":5,"text":"soft\nand ü"})"));
    CHECK(answer.number == 5);
    CHECK(answer.text == "soft\nand ü");
    CHECK(std::get<LeaveMessage>(read_message(R"({"t":"leave","n":13})")).n == 13);
    CHECK(std::get<StopMessage>(read_message(R"({"t":"stop","n":4294967295})")).n == 4294967295);
    CHECK(std::get<BeatMessage>(read_message(R"({"t":"beat","hidden":true})")).hidden);
}

TEST_CASE("studio messages: bad ones are refused by name") {
    const char* const wrong[] = {
        "",
        "{",
        "\xff",
        "[]",
        "{}",
        R"({"t":5})",
        R"({"t":"fly"})",
        R"({"t":"stop"})",
        R"({"t":"stream","n":1,"scene":"s"})",
        R"({"t":"stream","n":1,"scene":"s","index":-1})",
        R"({"t":"modulate","n":1})",
        R"({"t":"intensity","n":1})",
        R"({"t":"intensity","n":1,"value":1.001})",
        R"({"t":"intensity","n":1,"value":-0.1})",
        R"({"t":"intensity","n":1,"value":null})",
        R"({"t":"stop","n":-1})",
        R"({"t":"stop","n":1.5})",
        R"({"t":"stop","n":4294967296})",
        R"({"t":"stop","n":"1"})",
        R"({"t":"stop","n":1,"now":true})",
        R"({"t":"beat","hidden":0})",
        R"({"t":"scene","n":1,"document":[]})",
        R"({"t":"play","n":1,"scene":null})",
        R"({"t":"slice","n":1,"scene":"s","origin":[0,0],"u":[1,0,0],"v":[0,1,0],"width":2,"height":2,"view":0})",
        R"({"t":"slice","n":1,"scene":"s","origin":[0,0,"1"],"u":[1,0,0],"v":[0,1,0],"width":2,"height":2,"view":0})",
        R"({"t":"slice","n":1,"scene":"s","origin":[0,0,1],"u":[1,0,0],"v":[0,1,0],"width":2,"height":2,"view":0})",
        R"({"t":"slice","n":1,"scene":"s","origin":[0,0,1],"u":[1,0,0],"v":[0,1,0],"width":2,"height":2,"record":0,"view":4})",
        R"({"t":"reach","n":1,"scene":"s","origin":[0,0,1],"u":[1,0,0],"v":[0,1,0],"width":2,"height":2,"record":0,"view":0})",
        R"({"t":"reach","n":1,"scene":"s","origin":[0,0,1],"u":[1,0,0],"v":[0,1,0],"width":2,"height":2,"view":4})",
        R"({"t":"skin","n":1,"scene":"s","points":[1,2],"record":0,"view":0})",
        R"({"t":"skin","n":1,"scene":"s","points":[],"record":0,"view":0})",
        R"({"t":"skin","n":1,"scene":"s","points":[1,2,"3"],"record":0,"view":0})",
        R"({"t":"skin","n":1,"scene":"s","points":[1,2,3],"record":0,"view":4})",
        R"({"t":"drives","n":1,"scene":"s"})",
        R"({"t":"cancel","n":1})",
        R"({"t":"cancel","n":1,"what":"all"})",
        R"({"t":"pulses","n":1,"index":1})",
        R"({"t":"hand","n":1,"document":{}})",
        R"({"t":"hand","n":1,"document":{},"drawn":"\u0000"})",
        R"({"t":"path","n":1,"document":{},"drawn":""})",
        R"({"t":"path","n":1,"document":3})",
    };
    for (const char* text : wrong) {
        INFO(text);
        CHECK_REFUSED(read_message(text));
    }
}

TEST_CASE("studio messages: a study's files are in the project's folder, and its texts are short") {
    const auto with = [](const char* name, const nlohmann::json& value) {
        nlohmann::json message = nlohmann::json::parse(study_text);
        message[name] = value;
        return message.dump();
    };
    for (const char* name : {"", ".", "..", "../a.toml", "a/b.toml", "/etc/passwd", ".a.toml", "-o", "--help",
                             "a b.toml", "a\n.toml", "a\\b.toml", "ä.toml"}) {
        INFO(name);
        CHECK_REFUSED(read_message(with("protocol", name)));
        CHECK_REFUSED(read_message(with("results", std::string(name) + ".jsonl/")));
    }
    for (const char* name : {"p3.json", "p3", "jsonl", "/p3.jsonl", ".jsonl", "../p3.jsonl", "-p3.jsonl"}) {
        INFO(name);
        CHECK_REFUSED(read_message(with("results", name)));
    }
    CHECK_NOTHROW(read_message(with("protocol", std::string(100, 'a'))));
    CHECK_REFUSED(read_message(with("protocol", std::string(101, 'a'))));
    CHECK_NOTHROW(read_message(with("port", "")));
    CHECK_REFUSED(read_message(with("port", std::string(201, 'a'))));
    CHECK_REFUSED(read_message(with("port", "a\nb")));
    CHECK_REFUSED(read_message(with("participant", 0)));
    CHECK_REFUSED(read_message(with("participant", 100001)));
    CHECK_REFUSED(read_message(with("seed", -1)));
    CHECK_REFUSED(read_message(with("observer", "page")));
    const auto answer = [](const std::string& text) {
        return nlohmann::json{{"t", "answer"}, {"n", 1}, {"number", 1}, {"text", text}}.dump();
    };
    CHECK_NOTHROW(read_message(answer(std::string(4000, 'a'))));
    CHECK_REFUSED(read_message(answer(std::string(4001, 'a'))));
    CHECK_REFUSED(read_message(answer(std::string("a\0b", 3))));
    CHECK_REFUSED(read_message(answer("\x1b[2J")));
    CHECK_REFUSED(read_message(R"({"t":"leave","n":1,"now":true})"));
    CHECK_REFUSED(read_message(R"({"t":"studies"})"));
}

TEST_CASE("studio messages: text that was damaged is read or refused, and nothing else") {
    std::mt19937 random(Catch::rngSeed());
    std::size_t refused = 0;
    for (int i = 0; i < 20'000; ++i) {
        std::string text = slice_text;
        for (int change = 0; change < 3; ++change) {
            const std::size_t place = random() % text.size();
            if (random() % 2 == 0)
                text[place] = static_cast<char>(random() % 256);
            else
                text.erase(place, random() % 8);
            if (text.empty()) text = "x";
        }
        try {
            (void)read_message(text);
        } catch (const Error& error) {
            CHECK(error.code() == ErrorCode::bad_input);
            ++refused;
        }
    }
    CHECK(refused > 10'000);
}

TEST_CASE("studio messages: one as long as the server takes is refused at once, however it is nested or named") {
    const auto repeated = [](std::string_view piece, std::size_t times) {
        std::string text;
        for (std::size_t i = 0; i < times; ++i) text += piece;
        return text;
    };
    const auto document = [](const std::string& members) {
        return R"({"t":"scene","n":1,"document":{)" + members + "}}";
    };
    constexpr std::size_t many = most_message_bytes / 2 - 50;
    for (const std::string& deep :
         {document(R"("a":)" + repeated("[", many) + repeated("]", many)),
          document(R"("a":)" + repeated(R"({"a":)", many / 6) + "1" + repeated("}", many / 6)),
          repeated("[", 2 * many)}) {
        REQUIRE(deep.size() <= most_message_bytes);
        CHECK_REFUSED(read_message(deep));
    }
    const auto nested = [&](std::size_t depth) {  // in the message and its document
        return document(R"("a":)" + repeated("[", depth - 2) + repeated("]", depth - 2));
    };
    CHECK_NOTHROW(read_message(nested(most_nested)));
    CHECK_REFUSED(read_message(nested(most_nested + 1)));
    std::string names = R"("a":1)";
    for (int i = 0; names.size() < most_message_bytes - 100; ++i) names += ",\"" + std::to_string(i) + "\":1";
    CHECK_REFUSED(read_message(document(names)));

    // What looks deep or many within a text is none.
    const std::string quoted = R"("a":")" + repeated(R"(\\\"[{:)", 50'000) + "\"";
    CHECK(std::get<SceneMessage>(read_message(document(quoted))).document["a"].get<std::string>().size() == 250'000);
    std::string shapes = R"({"kind":"circle","diameter_mm":30,"center_mm":[0,0,120]})";
    shapes += repeated("," + shapes, 999);
    CHECK(std::get<SceneMessage>(read_message(document(R"("shape":[)" + shapes + "]"))).document["shape"].size() ==
          1000);
}

TEST_CASE("studio messages: what ends a connection or is answered over HTTP is text, whatever it quotes") {
    CHECK(close_reason("message 'stop': no") == "message 'stop': no");
    CHECK(close_reason("found '\xff\n\xc3\xa4'") == "found '" + std::string(4, '?') + "'");
    CHECK(close_reason(std::string(500, 'a')) == std::string(123, 'a'));
    const Answer answer = error_answer(422, "there is no scene '\xff'");
    CHECK(answer.status == 422);
    CHECK(nlohmann::json::parse(answer.body)["error"]["message"] == "there is no scene '\xEF\xBF\xBD'");
}

TEST_CASE("studio messages: bytes of a file that are no text do no harm in a message") {
    const std::string text = to_text(to_json(bad_input("a.xyz", "found '\xff\xc3('")));
    CHECK(nlohmann::json::parse(text)["message"] == "found '\xEF\xBF\xBD\xEF\xBF\xBD('");
}

TEST_CASE("studio messages: the bytes of a slice") {
    SliceMessage asked{9, "0123456789abcdef0123456789abXXXX", {{}, {}, {}, 3, 2}, 0, 0};
    const std::vector<float> values = {4, 5, 6, 7, 1, 2};
    const auto bytes = slice_bytes(asked, values, 1.5e-5, 2.25, 200);
    REQUIRE(bytes.size() == 64 + 24);
    CHECK(std::string(bytes.begin(), bytes.begin() + 4) == "HSL1");
    CHECK(at<std::uint32_t>(bytes, 4) == 9);
    CHECK(at<std::uint32_t>(bytes, 8) == 3);
    CHECK(at<std::uint32_t>(bytes, 12) == 2);
    CHECK(at<float>(bytes, 16) == 1.0F);
    CHECK(at<float>(bytes, 20) == 7.0F);
    CHECK(at<float>(bytes, 24) == 1.5e-5F);
    CHECK(at<float>(bytes, 28) == 2.25F);
    CHECK(at<std::uint32_t>(bytes, 32) == 200);
    CHECK(std::string(bytes.begin() + 36, bytes.begin() + 64) == "0123456789abcdef0123456789ab");
    for (std::size_t i = 0; i < values.size(); ++i) CHECK(at<float>(bytes, 64 + 4 * i) == values[i]);
}

TEST_CASE("studio messages: the bytes of an object") {
    Shape shape;
    shape.pieces.emplace_back(Mesh{{{0, 0, 0.1}, {0.01, 0, 0.1}, {0, 0.02, 0.1}, {0, 0, 0.3}}, {{1, 2, 0}, {1, 0, 2}}});
    shape.pieces.emplace_back(Curve{[](double s) { return Vec3{s, 0, 0}; }, 0.2, false});
    shape.pieces.emplace_back(Cloud{{{0.001, 0.002, 0.003}}});
    const auto bytes = shape_bytes(4, shape);
    // The two triangles share their corners, and the fourth vertex has none.
    REQUIRE(bytes.size() == 64 + 4 * (3 * 3 + 2 * 3 + 200 * 6 + 3));
    CHECK(std::string(bytes.begin(), bytes.begin() + 4) == "HOB1");
    const std::array<std::uint32_t, 6> counts{3, 2, 200, 1, 2, 1};
    for (std::size_t i = 0; i < counts.size(); ++i) CHECK(at<std::uint32_t>(bytes, 8 + 4 * i) == counts[i]);
    CHECK(at<float>(bytes, 64) == 10.0F);
    CHECK(at<float>(bytes, 64 + 4 * 4) == 20.0F);
    const std::array<std::uint32_t, 6> corners{0, 1, 2, 0, 2, 1};
    for (std::size_t i = 0; i < corners.size(); ++i) CHECK(at<std::uint32_t>(bytes, 64 + 4 * (9 + i)) == corners[i]);
    const std::size_t segments = 64 + 4 * (9 + 6);
    CHECK(at<float>(bytes, segments) == 0.0F);
    CHECK(at<float>(bytes, segments + 4 * 3) == Approx(1.0));                // the end of the first segment
    CHECK(at<float>(bytes, segments + 4 * (199 * 6 + 3)) == Approx(200.0));  // and of the last
    CHECK(at<float>(bytes, bytes.size() - 4) == Approx(3.0));
}

TEST_CASE("studio messages: the bytes and the numbers of a hand's frame") {
    HandView view;
    view.frame = 3;
    view.frames = 9;
    view.skin = {{Vec3{0.001, 0.002, 0.003}, {}, {}}, {Vec3{}, {}, {}}};
    view.strong = {{Vec3{0.004, 0.0, 0.0}, {}}};
    view.weak = {{Vec3{0.005, 0.0, 0.0}, {}}, {Vec3{}, {}}, {Vec3{}, {}}};
    view.foci = {{0.006, 0.0, 0.0}, {0.0, 0.0, 0.007}};
    const auto bytes = hand_bytes(77, view);
    CHECK(std::string(bytes.begin(), bytes.begin() + 4) == "HHA1");
    CHECK(at<std::uint32_t>(bytes, 4) == 77);
    const std::array<std::uint32_t, 4> counts{2, 1, 3, 2};
    for (std::size_t i = 0; i < 4; ++i) CHECK(at<std::uint32_t>(bytes, 8 + 4 * i) == counts[i]);
    REQUIRE(bytes.size() == 64 + 4 * (2 * 9 + 1 * 6 + 3 * 6 + 2 * 3));
    CHECK(at<float>(bytes, 64 + 4) == Approx(2.0F));
    CHECK(at<float>(bytes, 64 + 4 * 18) == Approx(4.0F));
    CHECK(at<float>(bytes, 64 + 4 * 24) == Approx(5.0F));
    CHECK(at<float>(bytes, 64 + 4 * 42) == Approx(6.0F));
    CHECK(at<float>(bytes, 64 + 4 * 47) == Approx(7.0F));
    CHECK(to_json(view)["report"].is_null());
    CHECK(to_json(view)["nothing"].is_null());
    view.nothing = bad_input("hand", "too far");
    CHECK(to_json(view)["nothing"]["message"] == "too far");
    view.report = FrameReport{};
    view.report->strength_pa = 2.5;
    CHECK(to_json(view)["report"]["strength_pa"] == 2.5);
    CHECK(to_json(view)["frames"] == 9);
}

TEST_CASE("studio messages: the bytes of an object that a hand feels: its surface and its edges") {
    const Mesh mesh{{{0.0, 0.0, 0.001}, {0.002, 0.0, 0.0}, {0.0, 0.003, 0.0}}, {{0, 1, 2}}};
    const auto bytes = touched_bytes(5, mesh, {{{0.0, 0.0, 0.0}, {0.004, 0.0, 0.0}, {0.0, 0.005, 0.0}}});
    CHECK(std::string(bytes.begin(), bytes.begin() + 4) == "HOB1");
    const std::array<std::uint32_t, 6> counts{3, 1, 2, 0, 1, 0};
    for (std::size_t i = 0; i < counts.size(); ++i) CHECK(at<std::uint32_t>(bytes, 8 + 4 * i) == counts[i]);
    REQUIRE(bytes.size() == 64 + 4 * (9 + 3 + 12));
    CHECK(at<float>(bytes, 64 + 8) == Approx(1.0F));
    CHECK(at<float>(bytes, 64 + 4 * 15) == Approx(4.0F));
    CHECK(at<float>(bytes, 64 + 4 * 22) == Approx(5.0F));
}

TEST_CASE("studio messages: a large object is drawn coarser, without holes, and the header says so") {
    // A dome of radius 50 mm over a disc of cells: its area is 2πr² whatever its triangles are.
    Mesh mesh;
    constexpr std::uint32_t rings = 200, sides = 400;
    for (std::uint32_t i = 0; i <= rings; ++i)
        for (std::uint32_t j = 0; j < sides; ++j) {
            const double a = 1.5707963267948966 * i / rings, b = 6.283185307179586 * j / sides;
            mesh.vertices.push_back(
                {0.05 * std::sin(a) * std::cos(b), 0.05 * std::sin(a) * std::sin(b), 0.05 * std::cos(a)});
        }
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t j = 0; j < sides; ++j) {
            const std::uint32_t k = i * sides + j, next = i * sides + (j + 1) % sides;
            mesh.triangles.push_back({k, k + sides, next});
            mesh.triangles.push_back({next, k + sides, next + sides});
        }
    Shape shape;
    shape.pieces.emplace_back(mesh);
    const auto bytes = shape_bytes(1, shape);
    const auto vertices = at<std::uint32_t>(bytes, 8), drawn = at<std::uint32_t>(bytes, 12);
    CHECK(at<std::uint32_t>(bytes, 24) == mesh.triangles.size());
    CHECK(drawn <= most_drawn_triangles);
    CHECK(drawn > most_drawn_triangles / 4);
    CHECK(vertices < drawn);  // which share them
    REQUIRE(bytes.size() == 64 + 12 * std::size_t{vertices} + 12 * std::size_t{drawn});
    double area = 0.0;
    for (std::uint32_t i = 0; i < drawn; ++i) {
        std::array<Vec3, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto number =
                at<std::uint32_t>(bytes, 64 + 12 * std::size_t{vertices} + 4 * (3 * std::size_t{i} + k));
            REQUIRE(number < vertices);
            const std::size_t place = 64 + 12 * std::size_t{number};
            corner[k] = {at<float>(bytes, place), at<float>(bytes, place + 4), at<float>(bytes, place + 8)};
            CHECK(std::hypot(corner[k].x, corner[k].y, corner[k].z) == Approx(50.0));  // a vertex of the mesh
        }
        const Vec3 u = corner[1] - corner[0], v = corner[2] - corner[0];
        area += std::hypot(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x) / 2.0;
    }
    CHECK(area == Approx(2.0 * 3.141592653589793 * 50.0 * 50.0).epsilon(0.05));  // no holes, and few folds
}
