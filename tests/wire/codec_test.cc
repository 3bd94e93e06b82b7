#include "common/wire/codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

std::string ReasonOf(const Decoded<GameRecord>& decoded) {
  const auto* malformed = std::get_if<Malformed>(&decoded);
  return malformed == nullptr ? "" : malformed->reason;
}

template <typename Message>
void ExpectSurvives(const Message& message) {
  const Decoded<WireMessage> decoded = Decode(Encode(message));
  ASSERT_TRUE(std::holds_alternative<WireMessage>(decoded)) << std::get<Malformed>(decoded).reason;
  EXPECT_EQ(std::get<Message>(std::get<WireMessage>(decoded)), message);
}

void ExpectRefused(const WireMessage& message) {
  EXPECT_TRUE(std::holds_alternative<Malformed>(Decode(Encode(message))));
}

TEST(RecordCodecTest, PlayedGamesComeBackAsTheyWere) {
  for (std::uint64_t ticket = 0; ticket < 20; ++ticket) {
    const GameRecord record = PlayTicket(QuickConfig(), ticket, /*weights_version=*/7);
    EXPECT_EQ(Verify(record), std::nullopt);
    GameRecord decoded = std::get<GameRecord>(DecodeRecord(EncodeRecord(record)));
    EXPECT_EQ(decoded.setup, GameSetup()) << "it follows from the ticket";
    decoded.setup = record.setup;
    EXPECT_EQ(decoded, record);
  }
}

TEST(RecordCodecTest, TakesFewBytesPerDecision) {
  std::size_t bytes = 0;
  std::size_t decisions = 0;
  for (std::uint64_t ticket = 0; ticket < 20; ++ticket) {
    const GameRecord record = PlayTicket(SelfPlayConfig{}, ticket);
    bytes += EncodeRecord(record).size();
    decisions += DecisionCount(record);
  }
  EXPECT_LE(bytes, 64 * decisions);
}

TEST(RecordCodecTest, ExtremesComeBackAsTheyWere) {
  constexpr auto kMost16 = std::numeric_limits<std::uint16_t>::max();
  constexpr auto kMost32 = std::numeric_limits<std::uint32_t>::max();
  GameRecord record;
  record.ticket = std::numeric_limits<std::uint64_t>::max();
  record.evaluator = std::string(128, 'e');
  record.actions = {{Action::kBomb, Action::kBomb, Action::kBomb, Action::kBomb}, JointAction{}};
  record.tracks[3] = {
      .weights_version = kMost32,
      .decisions = {{.step = 0, .visits = {1}, .value = -1, .weights_version = 0},
                    {.step = kMost16,
                     .visits = {kMost16, kMost16, kMost16, kMost16, kMost16, kMost16},
                     .value = 1,
                     .weights_version = kMost32}}};
  record.tracks[0].weights_version = 1;
  record.outcome = {.done = true, .result = Result::kWin, .winners = 5, .rewards = {1, -1, 1, -1}};
  EXPECT_EQ(std::get<GameRecord>(DecodeRecord(EncodeRecord(record))), record);
}

TEST(RecordCodecTest, ValuesAreRoundedToTheNearestStep) {
  for (const float value : {-1.0F, -0.33333F, 0.0F, 1e-6F, 0.7071F, 1.0F}) {
    EXPECT_NEAR(QuantiseValue(value), value, 0.5F / 32'767);
    EXPECT_EQ(QuantiseValue(QuantiseValue(value)), QuantiseValue(value));
  }
}

TEST(RecordCodecTest, SaysWhatIsOutOfRange) {
  const GameRecord good = PlayTicket(QuickConfig(), 0);
  GameRecord record = good;
  record.actions[0][2] = static_cast<Action>(7);
  EXPECT_THAT(ReasonOf(DecodeRecord(EncodeRecord(record))), HasSubstr("action"));
  record = good;
  record.evaluator = std::string(129, 'e');
  EXPECT_THAT(ReasonOf(DecodeRecord(EncodeRecord(record))), HasSubstr("evaluator"));
  record = good;
  record.outcome.rewards[1] = 2;
  EXPECT_THAT(ReasonOf(DecodeRecord(EncodeRecord(record))), HasSubstr("reward"));
  EXPECT_THAT(ReasonOf(DecodeRecord(std::string(kMaxRecordBytes + 1, 'x'))),
              HasSubstr("1048577 bytes"));
}

TEST(RecordCodecTest, DamagedBytesGiveAReasonOrAnotherRecord) {
  const std::string bytes = EncodeRecord(PlayTicket(QuickConfig(), 1));
  Rng rng(1);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    (void)DecodeRecord(std::string_view(bytes).substr(0, size));
  }
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = bytes;
    for (std::uint32_t flips = 1 + rng.Below(4); flips > 0; --flips) {
      damaged[rng.Below(static_cast<std::uint32_t>(damaged.size()))] =
          static_cast<char>(rng.Below(256));
    }
    const Decoded<GameRecord> decoded = DecodeRecord(damaged);
    if (const auto* record = std::get_if<GameRecord>(&decoded)) (void)Verify(*record);
  }
}

TEST(SealTest, FindsEveryFlippedBit) {
  SealedGame game = SealedTicket(QuickConfig(), 2);
  ASSERT_EQ(ReasonOf(Unseal(game)), "");
  for (std::size_t i = 0; i < game.record.size(); i += 7) {
    game.record[i] = static_cast<char>(game.record[i] ^ 1);
    EXPECT_THAT(ReasonOf(Unseal(game)), HasSubstr("checksum"));
    game.record[i] = static_cast<char>(game.record[i] ^ 1);
  }
}

TEST(SealTest, FindsAnotherTicket) {
  SealedGame game = SealedTicket(QuickConfig(), 2);
  game.ticket = 3;
  EXPECT_THAT(ReasonOf(Unseal(game)), HasSubstr("holds ticket 2"));
}

TEST(CodecTest, MessagesComeBackAsTheyWere) {
  SelfPlayConfig config = QuickConfig();
  config.search = PaperSettings();
  config.search.c_puct_init = 1.25;
  const Sha256Digest digest = SettingsDigest(config);
  ExpectSurvives(Hello{.run_id = "run",
                       .build = "0.1",
                       .name = "node-7.a_b",
                       .incarnation = ~std::uint64_t{0},
                       .loops = 3,
                       .tickets = {0, 5, ~std::uint64_t{0}}});
  ExpectSurvives(Welcome{.run_id = "run",
                         .self_play = config,
                         .settings_digest = digest,
                         .heartbeat = milliseconds(10),
                         .dead_after = milliseconds(20)});
  ExpectSurvives(Refused{.reason = "no", .retry = true});
  ExpectSurvives(Games{.games = {SealedTicket(QuickConfig(), 0), SealedTicket(QuickConfig(), 1)}});
  ExpectSurvives(
      Ack{.durable = {1, 2}, .rejected = {{.ticket = 3, .reason = "bad"}}, .tickets = {4}});
  ExpectSurvives(Ack{.tickets = {4, 5}, .past_versions = {0, 7}});
  ExpectRefused(Ack{.tickets = {4, 5}, .past_versions = {7}});
  ExpectSurvives(WeightsOffer{.version = 1, .size_bytes = 5, .sha256 = digest});
  const WeightsOffer offer{.version = 1, .size_bytes = 7, .sha256 = digest};
  ExpectSurvives(WeightsRequest{.version = 1, .offset_bytes = 5, .receipt = 9});
  ExpectSurvives(WeightsChunk{.offer = offer, .offset_bytes = 5, .data = std::string("\0\xff", 2)});
  ExpectSurvives(WeightsReceipt{.receipt = 9});
  ExpectSurvives(WeightsChunk{.offer = {.version = 3}, .offset_bytes = 5});  // gone
  ExpectSurvives(Heartbeat{.games = 1,
                           .steps = 2,
                           .decisions = 3,
                           .simulations = 4,
                           .evaluations = 5,
                           .batches = 6,
                           .games_running = 7,
                           .tickets_waiting = 8,
                           .outbox_games = 9,
                           .outbox_bytes = 10,
                           .oldest_ticket = 11,
                           .oldest_game = milliseconds(12),
                           .weights_version = 13});
  ExpectSurvives(Goodbye{.reason = "done", .run_complete = true});
}

TEST(CodecTest, RefusesWhatIsOutOfRange) {
  ExpectRefused(Hello{.name = ""});
  ExpectRefused(Hello{.name = "two words"});
  ExpectRefused(Hello{.name = "../../etc"});
  ExpectRefused(Hello{.name = "a", .loops = 0});
  ExpectRefused(Hello{.name = "a", .tickets = std::vector<std::uint64_t>(kMaxTickets + 1)});
  ExpectRefused(Welcome{.heartbeat = milliseconds(1000), .dead_after = milliseconds(1999)});
  ExpectRefused(Games{.games = {SealedGame{.record = std::string(kMaxRecordBytes + 1, 'x')}}});
  ExpectRefused(Games{.games = std::vector<SealedGame>(
                          3, SealedGame{.record = std::string(kMaxRecordBytes, 'x')})});
  ExpectRefused(WeightsOffer{.version = 0, .size_bytes = 1});
  ExpectRefused(WeightsOffer{.version = 1, .size_bytes = kMaxWeightsBytes + 1});
  const WeightsOffer offer{.version = 1, .size_bytes = kMaxWeightsBytes};
  ExpectRefused(WeightsChunk{.offer = offer, .data = std::string(kMaxChunkBytes + 1, 'x')});
  ExpectRefused(WeightsChunk{.offer = offer, .offset_bytes = kMaxWeightsBytes, .data = "x"});
  ExpectRefused(WeightsChunk{.offer = offer});
  ExpectRefused(WeightsChunk{.offer = {.version = 3}, .data = "x"});
}

TEST(CodecTest, ReasonsThatAreNoTextAreSentAsText) {
  const auto decoded = Decode(Encode(Refused{.reason = "bad \xff\n" + std::string(1000, 'x')}));
  const auto& refused = std::get<Refused>(std::get<WireMessage>(decoded));
  EXPECT_EQ(refused.reason.size(), 512u);
  EXPECT_THAT(refused.reason, testing::StartsWith("bad ??xxx"));
}

TEST(CodecTest, RefusesWhatIsNoEnvelope) {
  EXPECT_TRUE(std::holds_alternative<Malformed>(Decode("")));
  EXPECT_TRUE(std::holds_alternative<Malformed>(Decode("hello")));
  EXPECT_TRUE(std::holds_alternative<Malformed>(
      Decode(std::string(static_cast<std::size_t>(kMaxMessageBytes) + 1, '\0'))));
}

}  // namespace
}  // namespace powderkeg
