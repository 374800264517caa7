// chart.cpp - line plots by vtkChartXY.
#include "window.h"

#include <vtkAxis.h>
#include <vtkBrush.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkPen.h>
#include <vtkPlotPoints.h>
#include <vtkRenderer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <cmath>

using ylm::guarded;
template <class T> using Ptr = vtkSmartPointer<T>;

static void set_text(vtkTextProperty *p, double size, bool bold, const double rgb[3]) {
  if (const char *font = ylm::font_file(bold)) {
    p->SetFontFamily(VTK_FONT_FILE);
    p->SetFontFile(font);
    p->SetBold(0);
  } else
    p->SetBold(bold);
  p->SetItalic(0);
  p->SetShadow(0);
  p->SetFontSize(int(size + 0.5));
  p->SetColor(rgb[0], rgb[1], rgb[2]);
}

// Where a number stands on an axis: VTK draws floats, which tell numbers near to one another apart only from 0 to 1.
static double place(const ylm_vtk_axis *a, double x) {
  const double least = a->logarithmic ? std::log(a->least) : a->least;
  const double largest = a->logarithmic ? std::log(a->largest) : a->largest;
  return ((a->logarithmic ? std::log(x) : x) - least) / (largest - least);
}

static void set_axis(vtkAxis *axis, const ylm_vtk_axis *a, const ylm_vtk_chart *c, double k) {
  const double *fg = c->foreground, *bg = c->background;
  double grid[3];
  for (int i = 0; i < 3; i++) grid[i] = bg[i] + 0.10 * (fg[i] - bg[i]);
  axis->SetTitle("");
  set_text(axis->GetLabelProperties(), c->font * k, false, fg);
  axis->SetTitleVisible(false);
  axis->SetBehavior(vtkAxis::FIXED);
  axis->SetUnscaledRange(0, 1);
  axis->GetPen()->SetColorF(fg[0], fg[1], fg[2]);
  axis->GetPen()->SetWidth(float(1.2 * k));
  axis->SetTickLength(float(4 * k));
  axis->SetLabelOffset(float(8 * k));
  axis->GetGridPen()->SetColorF(grid[0], grid[1], grid[2]);
  axis->GetGridPen()->SetWidth(float(k));
  auto ticks = Ptr<vtkDoubleArray>::New();
  auto labels = Ptr<vtkStringArray>::New();
  for (size_t i = 0; i < a->ticks; i++) {
    ticks->InsertNextValue(place(a, a->tick[i]));
    labels->InsertNextValue(a->label[i]);
  }
  axis->SetCustomTickPositions(ticks, labels);
}

// A line of its points; the chart keeps the table. VTK refuses to draw lines of one point.
static void add_line(vtkChartXY *chart, const ylm_vtk_chart *c, const ylm_vtk_series *s, double k) {
  const bool points = s->width <= 0 || s->n < 2;
  auto x = Ptr<vtkDoubleArray>::New(), y = Ptr<vtkDoubleArray>::New();
  x->SetName("x");
  y->SetName(s->label && *s->label ? s->label : "y");
  for (size_t i = 0; i < s->n; i++) {
    x->InsertNextValue(place(&c->x, s->x[i]));
    y->InsertNextValue(place(&c->y, s->y[i]));
  }
  auto table = Ptr<vtkTable>::New();
  table->AddColumn(x);
  table->AddColumn(y);
  auto *plot =
      vtkPlotPoints::SafeDownCast(chart->AddPlot(points ? vtkChart::POINTS : vtkChart::LINE));
  plot->SetInputData(table, 0, 1);
  const auto byte = [](double v) {
    return (unsigned char)(v <= 0 ? 0 : v >= 1 ? 255 : v * 255 + 0.5);
  };
  plot->SetColor(byte(s->colour[0]), byte(s->colour[1]), byte(s->colour[2]), byte(s->colour[3]));
  plot->SetWidth(float(s->width * k));
  plot->SetLabel(s->label ? s->label : "");
  plot->SetLegendVisibility(s->label && *s->label);
  plot->GetPen()->SetLineType(s->dash == 1   ? vtkPen::DASH_LINE
                              : s->dash == 2 ? vtkPen::DOT_LINE
                                             : vtkPen::SOLID_LINE);
  plot->SetMarkerStyle(s->marker_size > 0 ? s->marker : vtkPlotPoints::NONE);
  plot->SetMarkerSize(float(s->marker_size * k));
}

static void set_legend(vtkChartXY *chart, const ylm_vtk_chart *c, double k) {
  chart->SetShowLegend(c->legend != 0);
  if (!c->legend) return;
  vtkChartLegend *legend = chart->GetLegend();
  legend->SetHorizontalAlignment(c->legend == 1 || c->legend == 3 ? vtkChartLegend::RIGHT
                                                                  : vtkChartLegend::LEFT);
  legend->SetVerticalAlignment(c->legend <= 2 ? vtkChartLegend::TOP : vtkChartLegend::BOTTOM);
  legend->SetInline(true);
  legend->SetPadding(int(8 * k));
  legend->SetSymbolWidth(int(26 * k));
  set_text(legend->GetLabelProperties(), c->font * k, false, c->foreground);
  legend->GetBrush()->SetColorF(c->background[0], c->background[1], c->background[2], 0.85);
  legend->GetPen()->SetColorF(c->foreground[0], c->foreground[1], c->foreground[2], 0.25);
  legend->GetPen()->SetWidth(float(k));
}

extern "C" ylm_status ylm_vtk_plot(const ylm_vtk_chart *c, uint8_t *rgb, ylm_error *e) {
  ylm_status good = ylm::check_sides("a plot", c->width, c->height, c->supersample, e);
  if (good != YLM_OK) return good;
  return guarded(e, [&] {
    ylm::ContextGuard guard;
    const double k = c->supersample;
    auto chart = Ptr<vtkChartXY>::New();
    chart->SetAutoSize(false);
    chart->SetLayoutStrategy(vtkChart::AXES_TO_RECT);
    chart->SetSize(vtkRectf(float(c->left * k), float(c->bottom * k),
                            float((c->width - c->left - c->right) * k),
                            float((c->height - c->bottom - c->top) * k)));
    chart->SetRenderEmpty(true);
    set_axis(chart->GetAxis(vtkAxis::BOTTOM), &c->x, c, k);
    set_axis(chart->GetAxis(vtkAxis::LEFT), &c->y, c, k);
    for (size_t i = 0; i < c->n; i++) add_line(chart, c, &c->series[i], k);
    set_legend(chart, c, k);
    auto actor = Ptr<vtkContextActor>::New();
    actor->GetScene()->AddItem(chart);
    auto renderer = Ptr<vtkRenderer>::New();
    renderer->SetBackground(c->background[0], c->background[1], c->background[2]);
    renderer->AddActor(actor);
    actor->GetScene()->SetRenderer(renderer);
    auto window = ylm::offscreen_window(c->width * c->supersample, c->height * c->supersample, e);
    if (!window) return YLM_EMISSING;
    window->SetMultiSamples(c->supersample > 1 ? 0 : 4);
    window->AddRenderer(renderer);
    window->Render();
    ylm_status status = ylm::read_pixels(window, c->width, c->height, c->supersample, rgb, e);
    window->RemoveRenderer(renderer);
    window->Finalize();
    return status;
  });
}
