#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/diagnosis/network.hpp"
#include "lcm_tools/spy/canvas.hpp"
#include "lcm_tools/spy/model.hpp"
#include "lcm_tools/spy/picture.hpp"

/// What the person sees and does: pages of the spy as pure functions of model, surroundings and
/// view state.
namespace marco::spy {

using diagnosis::Finding;
using diagnosis::Listener;
using diagnosis::Process;

enum class Page : uint8_t { table, channel, plot, picture, who, help };
enum class Column : uint8_t { channel, type, count, hz, jitter, bandwidth, age, undecodable, lost };
inline constexpr int kColumns = 9;

struct View {
  Page page = Page::table;
  Column sort = Column::channel;
  bool descending = false;
  std::string filter;          ///< part of a channel's or type's name, any case
  bool typing_filter = false;  ///< keys go to the filter
  bool paused = false;
  std::string selected;              ///< channel under the cursor
  std::string cursor;                ///< field under the cursor in the channel page
  std::set<std::string> unfolded;    ///< fields that show their parts, as "CHANNEL/path"
  std::vector<std::string> plotted;  ///< fields in the plot
  double zoom = 1;                   ///< of pictures
  int scroll = 0;                    ///< first row of the who page
  int page_rows = 10;                ///< rows of the last picture of the page, for page up and down
  bool asks_release = false;  ///< whether to release the emergency stop: the next key answers
};

/// What the last message on EMERGENCY_STOP says.
struct EmergencyStop {
  bool engaged = false;
  std::string sender;
  std::string reason;
};
/// @returns nothing if none has arrived or it cannot be decoded
std::optional<EmergencyStop> emergency_stop(const Model& model);

/// What is known besides the messages.
struct Surroundings {
  std::string source;  ///< URL or path of the log
  bool is_log = false;
  bool log_ended = false;
  bool overall_rates = false;  ///< rates from the first message to the last instead of the last 2 s
  double speed = 1;            ///< of a log
  int64_t now_us = 0;
  std::optional<EmergencyStop> emergency;  ///< the last one received
  std::map<Address, Process> publishers;
  std::vector<Listener> listeners;
  std::vector<Finding> findings;
  std::vector<std::string> problems;  ///< unreadable type sources, damage of the log
  /// Advice while no message arrives.
  std::vector<std::string> hints = {"To receive messages, run in another terminal:",
                                    "  marco-log play LOG   a recording, in real time",
                                    "or open a recording: marco-spy LOG"};
};

enum class Key : uint8_t { character, up, down, page_up, page_down, home, end, enter, back, erase };
struct KeyPress {
  Key key = Key::character;
  char character = 0;
};

/// What the session must do for a key.
enum class Action : uint8_t { none, quit, clear, next_type, pause, stop, release };

/// Applies the key to the view.
Action handle_key(View& view, KeyPress press, const Model& model, const Surroundings& around);

/// Channels in the order and selection of the table.
std::vector<int> visible_channels(const Model& model, const View& view, const Surroundings& around);
Rates rates_of(const Channel& channel, const Surroundings& around);
/// "planar_lidar_t (bot_core)", "a_t 1/2 (mine)" of two candidates, "?? e3d1..", "no type": the
/// type's own name first, so that cutting takes the package.
std::string type_text(const Model& model, const Channel& channel);

/// A row of the channel page: a field, or an element of an array.
struct FieldRow {
  std::string path;
  int depth = 0;
  std::string label;
  std::string type;
  std::string value;
  bool foldable = false;
  bool numeric = false;
  bool profile = false;  ///< an array of numbers: its sparkline is the array itself
  int node = 0;
};
/// The unfolded rows of a message, at most 3000.
std::vector<FieldRow> field_rows(const lcm_schema::Tree& tree,
                                 const std::string& channel,
                                 const View& view);

/// The number at "pos[2]" or "pose.x"; NaN when there is none.
double value_at(const lcm_schema::Tree& tree, const std::string& path);
/// The last `limit` values of a field in a channel's history, oldest first, with their times.
struct Series {
  std::vector<int64_t> times_us;
  std::vector<double> values;
};
Series series_of(const Model& model,
                 const Channel& channel,
                 const std::string& path,
                 std::size_t limit);

/// The whole screen.
Canvas draw(const Model& model, View& view, const Surroundings& around, int width, int height);

// The pages, between the first row (the title) and the last (the keys).
void draw_table(Canvas& canvas, const Model& model, View& view, const Surroundings& around);
void draw_channel(Canvas& canvas, const Model& model, View& view, const Surroundings& around);
void draw_plot(Canvas& canvas, const Model& model, const View& view);
void draw_who(Canvas& canvas, const Model& model, View& view, const Surroundings& around);

}  // namespace marco::spy
