// The log file itself: LCM's own reader and writer agree with ours, and no disk or file trouble goes
// unnoticed.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/event_log.h"

#include <csignal>
#include <gtest/gtest.h>
#include <lcm/eventlog.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "shared/core/check.h"
#include "shared/wire/event_log_format.h"
#include "tests/shared/wire/sample_messages.h"

namespace {
int synced_files = 0;
int sync_error = 0;  // the errno that syncing fails with; 0 = it works
}  // namespace

/// Takes the place of the C library's, so that tests see and fail it.
extern "C" int fdatasync(int file) {
  ++synced_files;
  if (sync_error == 0) return static_cast<int>(::syscall(SYS_fdatasync, file));
  errno = sync_error;
  return -1;
}

namespace kt {
namespace {

using Bytes = std::vector<uint8_t>;

struct StoredEvent {
  int64_t timestamp_us;
  std::string channel;
  Bytes data;
  friend bool operator==(const StoredEvent&, const StoredEvent&) = default;
};

const std::vector<StoredEvent> kEvents = {{1305031102160407, "KINTSUGI_POSE", {1, 2, 3}},
                                          {-5, "A", {}},
                                          {INT64_MAX, std::string(63, 'x'), Bytes(100000, 0xED)}};

std::vector<StoredEvent> read_all(EventLogReader& reader) {
  std::vector<StoredEvent> events;
  while (const auto event = reader.next()) {
    events.push_back(
        {event->timestamp_us, std::string(event->channel), {event->data.begin(), event->data.end()}});
  }
  return events;
}

void write_events(const std::filesystem::path& path, const std::vector<StoredEvent>& events) {
  EventLogWriter writer(path);
  for (const StoredEvent& event : events) writer.write(event.channel, event.timestamp_us, event.data);
  EXPECT_EQ(writer.event_count(), static_cast<int64_t>(events.size()));
  writer.close();
  EXPECT_EQ(static_cast<uintmax_t>(writer.byte_count()), std::filesystem::file_size(path));
}

TEST(EventLog, ReadsWhatItWrote) {
  const ScratchDir folder;
  write_events(folder / "a.lcm", kEvents);
  EventLogReader reader(folder / "a.lcm");
  EXPECT_EQ(read_all(reader), kEvents);
  EXPECT_TRUE(reader.integrity().is_sound());
  EXPECT_EQ(reader.integrity().events, 3);
  EXPECT_EQ(reader.position(), reader.size());
}

TEST(EventLog, LcmReadsOurs) {
  const ScratchDir folder;
  write_events(folder / "a.lcm", kEvents);
  lcm_eventlog_t* log = lcm_eventlog_create((folder / "a.lcm").c_str(), "r");
  ASSERT_NE(log, nullptr);
  for (size_t i = 0; i < kEvents.size(); ++i) {
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log);
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->eventnum, static_cast<int64_t>(i));
    EXPECT_EQ(event->timestamp, kEvents[i].timestamp_us);
    EXPECT_EQ(std::string(event->channel, static_cast<size_t>(event->channellen)), kEvents[i].channel);
    const auto* data = static_cast<const uint8_t*>(event->data);
    EXPECT_EQ(Bytes(data, data + event->datalen), kEvents[i].data);
    lcm_eventlog_free_event(event);
  }
  EXPECT_EQ(lcm_eventlog_read_next_event(log), nullptr);
  lcm_eventlog_destroy(log);
}

TEST(EventLog, WeReadLcmsToTheSameBytes) {
  const ScratchDir folder;
  lcm_eventlog_t* log = lcm_eventlog_create((folder / "lcm.lcm").c_str(), "w");
  ASSERT_NE(log, nullptr);
  for (StoredEvent event : kEvents) {
    lcm_eventlog_event_t raw{0,
                             event.timestamp_us,
                             static_cast<int32_t>(event.channel.size()),
                             static_cast<int32_t>(event.data.size()),
                             event.channel.data(),
                             event.data.data()};
    ASSERT_EQ(lcm_eventlog_write_event(log, &raw), 0);
  }
  lcm_eventlog_destroy(log);
  EventLogReader reader(folder / "lcm.lcm");
  EXPECT_EQ(read_all(reader), kEvents);
  write_events(folder / "ours.lcm", kEvents);
  EXPECT_EQ(read_bytes(folder / "lcm.lcm"), read_bytes(folder / "ours.lcm"));
}

TEST(EventLog, FindsTheNextEventBehindJunk) {
  const ScratchDir folder;
  write_events(folder / "a.lcm", {kEvents[0], kEvents[0]});
  const Bytes events = read_bytes(folder / "a.lcm");
  // Junk longer than the reader's search block, holding sync words that begin nothing.
  Bytes junk(200001, 0x55);
  for (const size_t at : {size_t{0}, size_t{65534}, size_t{131000}}) {
    const Bytes sync = {0xED, 0xA1, 0xDA, 0x01};
    std::copy(sync.begin(), sync.end(), junk.begin() + static_cast<std::ptrdiff_t>(at));
  }
  Bytes log = events;
  log.insert(log.begin() + static_cast<std::ptrdiff_t>(events.size() / 2), junk.begin(), junk.end());
  EventLogReader reader(log, "test");
  EXPECT_EQ(read_all(reader), (std::vector<StoredEvent>{kEvents[0], kEvents[0]}));
  EXPECT_EQ(reader.integrity().skipped_bytes, static_cast<int64_t>(junk.size()));
  EXPECT_FALSE(reader.integrity().truncated);
}

TEST(EventLog, RejectedEventOfWrongLengthGivesBackWhatItSwallowed) {
  const ScratchDir folder;
  write_events(folder / "a.lcm", {kEvents[0], kEvents[0], kEvents[0]});
  Bytes log = read_bytes(folder / "a.lcm");
  log[kDataLengthOffset + 3] += 10;  // the first event now reaches into the second
  EventLogReader reader(log, "test");
  ASSERT_TRUE(reader.next());
  EXPECT_FALSE(reader.is_followed_by_event());
  reader.reject();
  EXPECT_EQ(read_all(reader), (std::vector<StoredEvent>{kEvents[0], kEvents[0]}));
  EXPECT_EQ(reader.integrity().damaged_events, 1);
  EXPECT_EQ(reader.integrity().events, 2);
}

TEST(EventLog, RefusesWhatIsNoLog) {
  const ScratchDir folder;
  EXPECT_NE(error_of([&] { EventLogReader(folder / "none.lcm"); }).find("does not exist"), std::string::npos);
  EXPECT_NE(error_of([&] { EventLogReader(std::filesystem::path("/")); }).find("not a file"),
            std::string::npos);
  write_bytes(folder / "text.lcm", Bytes(100000, 'a'));
  EXPECT_NE(error_of([&] { EventLogReader(folder / "text.lcm"); }).find("text.lcm is not an LCM log"),
            std::string::npos);
  write_bytes(folder / "short.lcm", {'a'});
  EXPECT_NE(error_of([&] { EventLogReader(folder / "short.lcm"); }).find("not an LCM log"),
            std::string::npos);
}

TEST(EventLog, EmptyFileIsALogWithoutEvents) {
  const ScratchDir folder;
  write_bytes(folder / "empty.lcm", {});
  EventLogReader reader(folder / "empty.lcm");
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.integrity().is_sound());
}

TEST(EventLog, DoesNotOverwriteUnasked) {
  const ScratchDir folder;
  write_events(folder / "a.lcm", kEvents);
  const Bytes before = read_bytes(folder / "a.lcm");
  const std::string text = error_of([&] { EventLogWriter(folder / "a.lcm"); });
  EXPECT_NE(text.find("a.lcm exists"), std::string::npos) << text;
  EXPECT_NE(text.find("--overwrite"), std::string::npos) << text;
  EXPECT_EQ(read_bytes(folder / "a.lcm"), before);
}

TEST(EventLog, OverwritesOnlyWithTheFirstEvent) {
  const ScratchDir folder;
  write_events(folder / "a.lcm", kEvents);
  const Bytes before = read_bytes(folder / "a.lcm");
  EventLogWriter(folder / "a.lcm", true).close();
  { const EventLogWriter unused(folder / "a.lcm", true); }
  EXPECT_EQ(read_bytes(folder / "a.lcm"), before);
  EventLogWriter writer(folder / "a.lcm", true);
  writer.write("B", 1, Bytes{9});
  writer.close();
  EventLogReader reader(folder / "a.lcm");
  EXPECT_EQ(read_all(reader), (std::vector<StoredEvent>{{1, "B", {9}}}));
  EXPECT_TRUE(reader.integrity().is_sound());
}

TEST(EventLog, NewLogWithoutEventsIsRemoved) {
  const ScratchDir folder;
  EventLogWriter(folder / "a.lcm").close();
  { const EventLogWriter unused(folder / "a.lcm"); }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.lcm"));
}

TEST(EventLog, ALogInUseIsNotOverwritten) {
  const ScratchDir folder;
  write_events(folder / "a.lcm", kEvents);
  const Bytes before = read_bytes(folder / "a.lcm");
  const auto overwrite = [&] { EventLogWriter(folder / "a.lcm", true).write("B", 1, Bytes{9}); };
  {
    EventLogReader reader(folder / "a.lcm");
    const EventLogReader another(folder / "a.lcm");
    const std::string text = error_of(overwrite);
    EXPECT_NE(text.find("a.lcm is being read or written"), std::string::npos) << text;
    EXPECT_EQ(read_all(reader), kEvents);
  }
  {
    const EventLogWriter writer(folder / "a.lcm", true);
    EXPECT_NE(error_of(overwrite).find("a.lcm is being read or written"), std::string::npos);
    EventLogReader reader(folder / "a.lcm");  // reading is free
    EXPECT_EQ(read_all(reader), kEvents);
  }
  EXPECT_EQ(read_bytes(folder / "a.lcm"), before);
  EXPECT_EQ(error_of(overwrite), "");
}

TEST(EventLog, UnwritablePlaceIsAnErrorThatNamesIt) {
  EXPECT_NE(error_of([] { EventLogWriter("/nowhere/a.lcm"); }).find("/nowhere/a.lcm"), std::string::npos);
}

TEST(EventLog, FullDiskIsAnErrorEachTime) {
  EventLogWriter writer("/dev/full");
  for (int i = 0; i < 2; ++i) {
    const std::string text = error_of([&] { writer.write("A", 0, Bytes{1}); });
    EXPECT_THROW(writer.write("A", 0, Bytes{1}), DiskFullError);
    EXPECT_NE(text.find("/dev/full: No space left on device"), std::string::npos) << text;
  }
  EXPECT_EQ(writer.event_count(), 0);
}

TEST(EventLog, CloseWaitsForTheDisk) {
  const ScratchDir folder;
  synced_files = 0;
  write_events(folder / "a.lcm", kEvents);
  EXPECT_EQ(synced_files, 1);
  EventLogWriter writer(folder / "b.lcm");
  writer.write("A", 0, Bytes{1});
  sync_error = EIO;
  const std::string text = error_of([&] { writer.close(); });
  sync_error = 0;
  EXPECT_NE(text.find("b.lcm: Input/output error"), std::string::npos) << text;
}

TEST(EventLog, ADeviceNeedsNoSync) {
  EventLogWriter writer("/dev/null");
  writer.write("A", 0, Bytes{1});
  writer.close();
}

TEST(EventLog, DiskThatFillsUpKeepsEveryWholeEvent) {
  const ScratchDir folder;
  const auto path = folder / "a.lcm";
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{1050, limit.rlim_max};
  EventLogWriter writer(path);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  int64_t written = 0;
  const std::string text = error_of([&] {
    for (; written < 100; ++written) writer.write("CHANNEL", written, Bytes(65, 7));  // 100 bytes an event
  });
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(std::filesystem::file_size(path), 1000u);
  writer.write("CHANNEL", 10, Bytes(65, 7));  // there is room again
  EXPECT_NE(text.find("10 events written before are intact"), std::string::npos) << text;
  EXPECT_EQ(written, 10);
  EXPECT_EQ(std::filesystem::file_size(path), 1100u);
  EventLogReader reader(path);
  EXPECT_EQ(read_all(reader).size(), 11u);
  EXPECT_TRUE(reader.integrity().is_sound());
}

}  // namespace
}  // namespace kt
