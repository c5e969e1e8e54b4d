#pragma once

#include <deque>

#include "laboratory/trials/guidance/chest_camera.h"
#include "laboratory/trials/guidance/guidance_trial.h"
#include "laboratory/trials/guidance/guiding_server.h"
#include "laboratory/trials/guidance/leader.h"
#include "laboratory/trials/guidance/lock_step.h"
#include "laboratory/trials/guidance/true_frame.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::trials {

// When pictures are taken, and how much later what they tell is heard. The walker's clock stands
// still while the computer looks at one.
struct PictureTimes {
  double pictures_per_s = 2;
  double latency_s = 0.3;  // from a picture to the answer

  [[nodiscard]] Expected<void> validate() const;
};

// A computer that sees only what the walker's camera sends, and is asked by the goal's name.
class ServerLeader final : public Leader {
 public:
  // `view`: of the home that is served, for who judges. Fails where the connection does.
  [[nodiscard]] static Expected<std::unique_ptr<ServerLeader>> begin(
      std::unique_ptr<service::ServerConnection> connection,
      std::shared_ptr<const live::HomeView> view, const TrueFrame& frame, const GuidedGoal& goal,
      const guide::SpeakingStyle& style, const ChestCameraOptions& options, ChestCamera camera,
      const PictureTimes& times);

  [[nodiscard]] Expected<std::vector<guide::Prompt>> after_step(
      double now_s, const SimulatedWalker& walker) override;
  [[nodiscard]] Expected<std::vector<guide::Prompt>> request(guide::GuidanceRequest request,
                                                             double now_s) override;
  [[nodiscard]] bool knows_goal() const override { return knows_goal_; }
  [[nodiscard]] bool is_over() const override { return is_over_; }
  [[nodiscard]] bool says_there() const override { return says_there_; }
  // By a way that the same map gives from where the walker truly is.
  [[nodiscard]] std::optional<Eigen::Vector2d> next_place(
      const SimulatedWalker& walker) const override;
  [[nodiscard]] const Sightings& sightings() const override { return sightings_; }

 private:
  ServerLeader(LockStep device, std::shared_ptr<const live::HomeView> view, const TrueFrame& frame,
               ChestCamera camera, const PictureTimes& times)
      : device_(std::move(device)),
        view_(std::move(view)),
        frame_(frame),
        camera_(std::move(camera)),
        times_(times) {}
  [[nodiscard]] Expected<void> show_picture(double now_s);
  void note_end(const std::vector<guide::Prompt>& prompts);

  LockStep device_;
  std::shared_ptr<const live::HomeView> view_;
  TrueFrame frame_;
  ChestCamera camera_;
  PictureTimes times_;
  bool sends_depth_ = true;
  service::Ask goal_;
  service::SpeakingSettings settings_;
  double next_picture_s_ = 0;
  bool has_asked_ = false;
  struct Answer {
    double due_s = 0;
    std::vector<guide::Prompt> prompts;
  };
  std::deque<Answer> answers_;
  bool knows_goal_ = false, is_over_ = false, says_there_ = false;
  Sightings sightings_;
};

// All that walks share whose pictures are drawn; what it refers to must outlive it.
struct DrawnWalks {
  const GuidingServer& server;
  const simulation::Renderer& renderer;
  ThreadPool& pool;
  TrueFrame frame;
  ChestCameraOptions camera = {};
  PictureTimes times = {};
};
// As lead(), by the computer. One that cannot be reached is a walk that was broken off.
[[nodiscard]] GuidedWalk lead_by_server(const DrawnWalks& walks, const WalkedHome& home,
                                        const GuidedGoal& goal, const TrialOptions& options,
                                        std::uint64_t walk);

}  // namespace roomwise::trials
