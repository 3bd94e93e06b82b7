#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pommerman/board_reader.h"
#include "tests/pommerman/position.h"

namespace powderkeg {
namespace {

TEST(BoardText, PrintsWhatTheHeaderSays) {
  const State state = Position({"01#+o*b", "+"},
                               "step 12\nagent 0 ammo 2 strength 3 kick words 1 7\n"
                               "agent 2 dead (9,9)\nbomb (0,4) owner 1 life 5 moving left\n"
                               "bomb (0,0) owner 0\nflame (0,5) life 1\nhidden (1,0) r");
  EXPECT_EQ(ToText(state),
            "01#+o*b....\n"
            "+..........\n"
            "...........\n...........\n...........\n...........\n...........\n"
            "...........\n...........\n...........\n...........\n"
            "step 12\n"
            "agent 0 ammo 2 strength 3 kick words 1 7\n"
            "agent 1 ammo 1 strength 2\n"
            "agent 2 dead (9,9) ammo 1 strength 2\n"
            "agent 3 dead (0,0) ammo 1 strength 2\n"
            "bomb (0,4) owner 1 life 5 strength 2 moving left\n"
            "bomb (0,0) owner 0 life 9 strength 2\n"
            "flame (0,5) life 1\n"
            "hidden (1,0) r\n");
  EXPECT_EQ(FromText(ToText(state)), state);
}

TEST(BoardText, FillsInWhatNoLineDescribes) {
  const State state = Position({"o*3"});
  EXPECT_EQ(state.bombs[0], (Bomb{.cell = 0, .life = 9}));
  EXPECT_EQ(state.flames[2], BitBoard::Of(1));
  EXPECT_TRUE(state.agents[3].alive);
  EXPECT_FALSE(state.agents[0].alive);
}

TEST(BoardText, IgnoresBlanks) {
  const State state = Position({"0b"}, "\n   agent 0   ammo 4\t\r\n\n");
  EXPECT_EQ(state.agents[0].ammo, 4);
}

std::string ErrorOf(std::string_view row, std::string_view attributes) {
  try {
    (void)Position({row}, attributes);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(BoardText, SaysWhatIsWrong) {
  using testing::HasSubstr;
  EXPECT_THAT(ErrorOf("x", ""), HasSubstr("unknown cell 'x'"));
  EXPECT_THAT(ErrorOf("?", ""), HasSubstr("unknown cell '?'"));
  EXPECT_THAT(ErrorOf("00", ""), HasSubstr("agent 0 is on the board twice"));
  EXPECT_THAT(ErrorOf("", "frog"), HasSubstr("unknown word 'frog'"));
  EXPECT_THAT(ErrorOf("", "step -1"), HasSubstr("'-1' is no number from 0 to 65535"));
  EXPECT_THAT(ErrorOf("", "step"), HasSubstr("'' is no number"));
  EXPECT_THAT(ErrorOf("", "step 1 2"), HasSubstr("unexpected '2'"));
  EXPECT_THAT(ErrorOf("", "agent 4"), HasSubstr("'4' is no number from 0 to 3"));
  EXPECT_THAT(ErrorOf("", "agent 0 ammo 1"), HasSubstr("neither on the board nor dead"));
  EXPECT_THAT(ErrorOf("0", "agent 0 dead (1,1)"), HasSubstr("the agent is on the board"));
  EXPECT_THAT(ErrorOf("0", "agent 0 fast"), HasSubstr("unknown word 'fast'"));
  EXPECT_THAT(ErrorOf("", "bomb (0,0)"), HasSubstr("neither bomb nor agent"));
  EXPECT_THAT(ErrorOf("o", "bomb (0,11)"), HasSubstr("'(0,11)' is no cell"));
  EXPECT_THAT(ErrorOf("o", "bomb 0,0"), HasSubstr("is no cell"));
  EXPECT_THAT(ErrorOf("o", "bomb"), HasSubstr("'' is no cell"));
  EXPECT_THAT(ErrorOf("o", "bomb (0,0)\nbomb (0,0)"), HasSubstr("a second bomb"));
  EXPECT_THAT(ErrorOf("o", "bomb (0,0) moving away"), HasSubstr("unknown word 'away'"));
  EXPECT_THAT(ErrorOf("o", "bomb (0,0) strength 0"), HasSubstr("no number from 1"));
  EXPECT_THAT(ErrorOf("", "flame (0,0) life 1"), HasSubstr("shows no flame"));
  EXPECT_THAT(ErrorOf("*", "flame (0,0) life 3"), HasSubstr("from 0 to 2"));
  EXPECT_THAT(ErrorOf("*", "flame (0,0) 2"), HasSubstr("expected 'life'"));
  EXPECT_THAT(ErrorOf("+", "hidden (0,0) q"), HasSubstr("expected one of b, r, k"));
  EXPECT_THAT(ErrorOf("", "hidden (0,0) b"), HasSubstr("lies open"));
}

TEST(BoardText, NeedsElevenRowsOfElevenCells) {
  EXPECT_THROW((void)FromText(""), Error);
  EXPECT_THROW((void)FromText("...........\n...........\n"), Error);
  EXPECT_THROW((void)FromText(std::string(11, '\n') + "..."), Error);
}

TEST(BoardText, HoldsFortyBombsAndNoMore) {
  const std::string row(11, 'o');
  EXPECT_THROW((void)Position({row, row, row, row}), Error);
  EXPECT_EQ(Position({row, row, row, "ooooooo"}).bomb_count, 40);
}

}  // namespace
}  // namespace powderkeg
