// A page and the query that it writes once it is opened are one step of the browser's history: Back leaves the page.
if (!window.corsmalHistory) {
  window.corsmalHistory = true;
  const push = history.pushState.bind(history);
  history.pushState = (state, title, url) => {
    const next = new URL(url ?? location.href, location.href);
    const isCompleted = next.pathname === location.pathname && !location.search && next.search;
    if (isCompleted) history.replaceState(state, title, url);
    else push(state, title, url);
  };
}
