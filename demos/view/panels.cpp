// Two panels: what runs and what is shown at the left, what it costs and what was picked at the right.
#include "view/panels.h"

#include <BulletSoftBody/btSoftBody.h>

#include <imgui.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <iterator>
#include <set>
#include <unistd.h>

namespace
{
constexpr float s_width = 292, s_gap = 12;
constexpr char s_font[] = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

ImVec4 ColorOf(const btVector3& color)
{
    return ImVec4(float(color.x()), float(color.y()), float(color.z()), 1);
}

void BeginPanel(const char* name, float x)
{
    ImVec2 size = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos(ImVec2(x, s_gap));
    ImGui::SetNextWindowSizeConstraints(ImVec2(s_width, 0), ImVec2(s_width, size.y - 2 * s_gap));
    ImGui::Begin(name, nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings);
}

void Heading(const char* text)
{
    ImGui::Spacing();
    ImGui::TextColored(ImVec4(0.16f, 0.38f, 0.62f, 1), "%s", text);
    ImGui::Separator();
}

/// A label at the left and a value at the right end of a row.
void Row(const char* label, const char* value)
{
    ImGui::TextUnformatted(label);
    ImGui::SameLine(std::max(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(value).x, 0.0f));
    ImGui::TextUnformatted(value);
}

template <typename... Values> std::string Format(const char* format, Values... values)
{
    char text[128];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

void DrawRun(qcViewedScene* scene, qcViewState* state)
{
    ImVec2 button((s_width - 16 - 2 * 8) / 3, 0);
    ImGui::TextColored(ImVec4(0.16f, 0.38f, 0.62f, 1), "%s", scene->Title());
    ImGui::Separator();
    if (ImGui::Button(state->paused ? "Run" : "Pause", button) && !state->finished)
        state->paused = !state->paused;
    ImGui::SameLine(0, 8);
    if (ImGui::Button("Step", button) && !state->finished)
        state->paused = state->stepOnce = true;
    ImGui::SameLine(0, 8);
    if (ImGui::Button("Restart", button))
        state->restart = true;
    ImGui::TextDisabled("Space, N, R");
    Row("time", Format("%.3f s, step %" PRIu64, double(state->steps) * scene->StepSeconds(), state->steps).c_str());
    Row("frames a second", Format("%.1f", state->framesASecond).c_str());
    if (!state->message.empty())
    {
        ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.75f, 0.1f, 0.05f, 1));
        ImGui::TextWrapped("%s", state->message.c_str());
        ImGui::PopStyleColor();
    }
}

void Legend(const btVector3& color, const char* text, bool sameLine)
{
    if (sameLine)
        ImGui::SameLine();
    ImGui::ColorButton(text, ColorOf(color), ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoDragDrop,
                       ImVec2(12, 12));
    ImGui::SameLine(0, 4);
    ImGui::TextUnformatted(text);
}

void DrawSets(const qcViewSets& sets, qcViewState* state)
{
    qcViewRequest& request = state->request;
    std::string size = Format("%d x %d", 1 << request.resolutionPower, 1 << request.resolutionPower);
    ImGui::SetNextItemWidth(150);
    ImGui::SliderInt("pixels", &request.resolutionPower, 6, 12, size.c_str());
    ImGui::SetNextItemWidth(150);
    ImGui::Combo("views", &request.views, qcViewAxes, int(std::size(qcViewAxes)));
    ImGui::SetNextItemWidth(150);
    ImGui::SliderInt("rounds", &request.rounds, 1, 4);
    if (state->marks == qc_marksSets)
    {
        Legend(qcColorOfSet(qc_setFfv), Format("FFV %u", sets.ffv).c_str(), false);
        Legend(qcColorOfSet(qc_setSfv), Format("SFV %u", sets.sfv).c_str(), true);
        Legend(qcColorOfSet(qc_setNfv), Format("NFV %u", sets.nfv).c_str(), true);
    }
    Row("PCS of Quick-CULLIDE", Format("%u", sets.ffv + sets.sfv + sets.nfv).c_str());
    Row("penetrating pairs it finds", Format("%zu", sets.pairs).c_str());
    Row("time of it", Format("%.1f ms", sets.ms).c_str());
}

void DrawShow(const qcViewSets& sets, qcViewState* state)
{
    Heading("Show");
    const std::pair<const char*, qcViewMarks> marks[] = {{"plain", qc_marksNone},
                                                         {"PCS of the simulation's queries", qc_marksPcs},
                                                         {"PCS of Quick-CULLIDE", qc_marksQuick},
                                                         {"FFV, SFV, NFV of Quick-CULLIDE", qc_marksSets}};
    for (const auto& [label, value] : marks)
        if (state->hasGl || value < qc_marksQuick)
            if (ImGui::RadioButton(label, state->marks == value))
                state->marks = value;
    if (state->marks >= qc_marksQuick)
        DrawSets(sets, state);
    const std::pair<const char*, int> modes[] = {{"candidate pairs", qc_drawCandidates},
                                                 {"contacts", qc_drawContacts},
                                                 {"manifolds", qc_drawManifolds},
                                                 {"boxes", qc_drawBoxes},
                                                 {"planes, zones", qc_drawPlanes}};
    int column = 0;
    for (const auto& [label, bit] : modes)
    {
        if (column++ % 2 == 1)
            ImGui::SameLine(s_width / 2);
        ImGui::CheckboxFlags(label, &state->modes, bit);
    }
}

void DrawSetting(const qcViewSetting& setting, size_t index, qcViewState* state)
{
    ImGui::SetNextItemWidth(150);
    double present = setting.get(), value = present;
    if (setting.choices.empty())
    {
        ImGui::SliderScalar(setting.label.c_str(), ImGuiDataType_Double, &value, &setting.lowest, &setting.highest,
                            setting.format);
    }
    else if (ImGui::BeginCombo(setting.label.c_str(), setting.choices[size_t(present)].c_str()))
    {
        for (size_t i = 0; i < setting.choices.size(); i++)
            if (ImGui::Selectable(setting.choices[i].c_str(), double(i) == present))
                value = double(i);
        ImGui::EndCombo();
    }
    if (value == present)
        return;
    state->changedSetting = index + 1;
    state->newValue = value;
}

void DrawBars(const qcViewCosts& costs)
{
    const qcStepCosts& mean = costs.Mean();
    double highest = 1e-6, total = mean.Total();
    for (double ms : mean.ms)
        highest = std::max(highest, ms);
    Row("the whole step", Format("%.2f ms", total).c_str());
    std::vector<float> totals(costs.Totals().begin(), costs.Totals().end());
    float top = totals.empty() ? 1 : *std::max_element(totals.begin(), totals.end());
    ImGui::PlotLines("##totals", totals.data(), int(totals.size()), 0, nullptr, 0, 1.1f * top,
                     ImVec2(s_width - 16, 44));
    float line = ImGui::GetTextLineHeight();
    for (size_t i = 0; i < qc_costCount; i++)
    {
        if (!(mean.ms[i] > 0.005))
            continue;
        ImVec2 at = ImGui::GetCursorScreenPos();
        float share = float(mean.ms[i] / highest);
        // Bullet's own stages are grey.
        bool isBullet = std::string(qcStepCostLabel(qcStepCost(i))).compare(0, 6, "Bullet") == 0;
        ImGui::GetWindowDrawList()->AddRectFilled(
            ImVec2(at.x, at.y), ImVec2(at.x + std::max(share * (s_width - 16), 2.0f), at.y + line),
            isBullet ? IM_COL32(196, 200, 206, 255) : IM_COL32(150, 190, 228, 255), 2);
        Row(qcStepCostLabel(qcStepCost(i)), Format("%.2f", mean.ms[i]).c_str());
    }
}

void DrawStatistics(const qcViewPanelInput& input)
{
    btDiscreteDynamicsWorld& world = input.scene->World();
    std::set<const btCollisionObject*> objects;
    size_t triangles = 0;
    for (const qcViewSurface& surface : *input.surfaces)
    {
        objects.insert(surface.object);
        triangles += surface.unbounded ? 0 : surface.triangles->indices.size() / 3;
    }
    int points = 0;
    btDispatcher* dispatcher = world.getDispatcher();
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
        points += dispatcher->getManifoldByIndexInternal(m)->getNumContacts();
    Row("objects, triangles", Format("%zu, %zu", objects.size(), triangles).c_str());
    Row("pairs of boxes", Format("%d", world.getPairCache()->getNumOverlappingPairs()).c_str());
    Row("manifolds, points", Format("%d, %d", dispatcher->getNumManifolds(), points).c_str());
    for (const qcViewStatistic& statistic : input.scene->Statistics())
        Row(statistic.label.c_str(), statistic.value.c_str());
}

int CountContacts(btDispatcher* dispatcher, const btCollisionObject* object)
{
    int points = 0;
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
    {
        const btPersistentManifold* manifold = dispatcher->getManifoldByIndexInternal(m);
        if (manifold->getBody0() == object || manifold->getBody1() == object)
            points += manifold->getNumContacts();
    }
    return points;
}

void DrawPicked(const qcViewPanelInput& input, const qcViewState& state)
{
    Heading("Picked");
    size_t triangles = 0;
    const qcViewSurface* picked = nullptr;
    for (const qcViewSurface& surface : *input.surfaces)
        if (surface.object == state.picked)
        {
            picked = &surface;
            triangles += surface.triangles->indices.size() / 3;
        }
    if (picked == nullptr)
    {
        ImGui::TextDisabled("click on a body; F looks at it");
        return;
    }
    ImGui::TextUnformatted(qcNameOf(*input.scene, *picked).c_str());
    Row("triangles", Format("%zu", triangles).c_str());
    btDispatcher* dispatcher = input.scene->World().getDispatcher();
    Row("contact points", Format("%d", CountContacts(dispatcher, state.picked)).c_str());
    if (const btRigidBody* body = btRigidBody::upcast(state.picked))
    {
        Row("mass", body->getInvMass() > 0 ? Format("%.4g kg", 1 / double(body->getInvMass())).c_str() : "fixed");
        Row("speed", Format("%.3f m/s", double(body->getLinearVelocity().length())).c_str());
        Row("spin", Format("%.3f rad/s", double(body->getAngularVelocity().length())).c_str());
    }
    else if (const btSoftBody* soft = btSoftBody::upcast(state.picked))
    {
        Row("nodes", Format("%d", soft->m_nodes.size()).c_str());
        Row("mass", Format("%.4g kg", double(soft->getTotalMass())).c_str());
    }
    Row("active", state.picked->isActive() ? "yes" : "no");
}
} // namespace

void qcViewCosts::Add(const qcStepCosts& costs)
{
    double weight = m_totals.empty() ? 1 : 0.1;
    for (double& ms : m_mean.ms)
        ms *= 1 - weight;
    m_mean.Add(costs, weight);
    m_totals.push_back(float(costs.Total()));
    if (m_totals.size() > 240)
        m_totals.pop_front();
}

void qcViewCosts::Clear()
{
    *this = qcViewCosts();
}

void qcStylePanels()
{
    ImGui::StyleColorsLight();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = 8;
    style.FrameRounding = 4;
    style.WindowPadding = ImVec2(8, 8);
    style.ItemSpacing = ImVec2(8, 3);
    style.WindowBorderSize = 0;
    style.Colors[ImGuiCol_WindowBg] = ImVec4(0.98f, 0.98f, 0.99f, 0.86f);
    style.Colors[ImGuiCol_FrameBg] = ImVec4(0.88f, 0.90f, 0.93f, 1);
    style.Colors[ImGuiCol_SliderGrab] = ImVec4(0.45f, 0.65f, 0.88f, 0.6f);
    style.Colors[ImGuiCol_PlotLines] = ImVec4(0.16f, 0.38f, 0.62f, 1);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    if (access(s_font, R_OK) == 0)
        io.Fonts->AddFontFromFileTTF(s_font, 13);
}

void qcDrawPanels(const qcViewPanelInput& input, qcViewState* state)
{
    BeginPanel("left", s_gap);
    DrawRun(input.scene, state);
    DrawShow(*input.sets, state);
    if (!input.settings->empty())
        Heading("Settings");
    for (size_t i = 0; i < input.settings->size(); i++)
        DrawSetting((*input.settings)[i], i, state);
    ImGui::End();
    BeginPanel("right", ImGui::GetIO().DisplaySize.x - s_width - s_gap);
    ImGui::TextColored(ImVec4(0.16f, 0.38f, 0.62f, 1), "Milliseconds of a step");
    ImGui::Separator();
    DrawBars(*input.costs);
    Heading("Step");
    DrawStatistics(input);
    DrawPicked(input, *state);
    ImGui::End();
}

std::string qcNameOf(const qcViewedScene& scene, const qcViewSurface& surface)
{
    std::string name = scene.NameOf(surface.object);
    if (!name.empty())
        return name;
    bool isSoft = btSoftBody::upcast(surface.object) != nullptr;
    return (isSoft ? "soft body " : surface.object->getCollisionShape()->getName() + std::string(" ")) +
           std::to_string(surface.number);
}

btVector3 qcColorOfSet(qcVisibilitySet set)
{
    if (set == qc_setFfv)
        return btVector3(btScalar(0.13), btScalar(0.42), btScalar(0.86));
    if (set == qc_setSfv)
        return btVector3(btScalar(0.10), btScalar(0.62), btScalar(0.30));
    return btVector3(btScalar(0.88), btScalar(0.10), btScalar(0.08));
}
